// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "core/base/camera_model.hpp"
#include "core/base/image.hpp"
#include "core/base/rigid_motion.hpp"
#include "drivers/simulated/synthetic/synthetic.hpp"

#include <cstdint>
#include <memory>

namespace afterglow {

/// When a picture is taken, by the time of an image.
struct Exposed {
    double delay_s = 0;   ///< from the image's middle row to the picture's
    double readout_s = 0; ///< from the picture's first row to the last; 0 = all rows at once
};

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
    /// Millimetres along Z, rounded, of every pixel centre of image k, when its row is exposed; no
    /// noise and no range limits. 0 where there is nothing to see.
    DepthMap depth(std::uint64_t k);
    /// The same of any camera on the colour camera's body, at `exposure`.
    DepthMap depth(std::uint64_t k, const CameraModel &camera, const Pose &camera_from_color,
                   const Exposed &exposure = {});
    /// Image k without noise and changes of exposure.
    Luma luma(std::uint64_t k);
    /// Takes world points to the colour camera's frame at image k, or `delay_s` after it.
    Pose world_to_camera(std::uint64_t k, double delay_s = 0) const;

private:
    struct State;
    std::unique_ptr<State> state_;
};

} // namespace afterglow
