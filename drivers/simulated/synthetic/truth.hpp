// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "core/base/camera.hpp"
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

    const Intrinsics &intrinsics() const;
    /// Millimetres, rounded, of every pixel centre; no noise and no range limits. 0 where there is
    /// nothing to see.
    DepthMap depth(std::uint64_t k);
    /// Image k without noise.
    Luma luma(std::uint64_t k);
    /// Takes world points to the camera's frame at image k.
    Pose world_to_camera(std::uint64_t k) const;

private:
    struct State;
    std::unique_ptr<State> state_;
};

} // namespace afterglow
