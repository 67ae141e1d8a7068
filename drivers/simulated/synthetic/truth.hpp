// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "core/base/camera_model.hpp"
#include "core/base/image.hpp"
#include "core/base/rigid_motion.hpp"
#include "drivers/simulated/synthetic/synthetic.hpp"

#include <cstdint>
#include <memory>

namespace afterglow {

/// The true depth and pose of a synthetic rig's frames, for the evaluation: equal options give
/// equal worlds in every process. Image k is the one with ColorFrame::sequence k.
class SyntheticTruth {
public:
    explicit SyntheticTruth(const SyntheticOptions &options);
    SyntheticTruth(const SyntheticOptions &options, SyntheticWorld world);
    ~SyntheticTruth();
    SyntheticTruth(SyntheticTruth &&) noexcept;

    /// Of the colour camera; of two cameras' without its lens.
    const Intrinsics &intrinsics() const;
    /// Millimetres, rounded, of every pixel centre of the colour camera at its time, that of the
    /// middle row; no noise and no range limits. 0 where there is nothing to see.
    DepthMap depth(std::uint64_t k);
    /// The same, along Z, of any camera on the colour camera's body, and `delay_s` after image k.
    DepthMap depth(std::uint64_t k, const CameraModel &camera, const Pose &camera_from_color,
                   double delay_s = 0);
    /// Image k without noise and changes of exposure.
    Luma luma(std::uint64_t k);
    /// Takes world points to the colour camera's frame at image k, or `delay_s` after it.
    Pose world_to_camera(std::uint64_t k, double delay_s = 0) const;

private:
    struct State;
    std::unique_ptr<State> state_;
};

} // namespace afterglow
