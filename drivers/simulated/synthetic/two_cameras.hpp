// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "drivers/simulated/sequence_rig.hpp"
#include "drivers/simulated/synthetic/exposure.hpp"
#include "drivers/simulated/synthetic/lens_renderer.hpp"
#include "drivers/simulated/synthetic/synthetic.hpp"
#include "drivers/simulated/synthetic/tof_camera.hpp"

#include <cstdint>

namespace afterglow {

/// The frames of two cameras on one body, synthetic_rig(): images through a lens and a
/// rolling shutter, and what the TOF camera beside it measures.
class TwoCameras : public FrameSequence {
public:
    TwoCameras(const SyntheticOptions &options, SyntheticWorld world);
    TwoCameras(const TwoCameras &) = delete; // the renderers hold on to the scene
    TwoCameras &operator=(const TwoCameras &) = delete;

    const Intrinsics &intrinsics() const override { return rig_.color.pinhole; }
    const Intrinsics &tof_intrinsics() const override { return rig_.tof.pinhole; }
    std::optional<std::int64_t> time_ns(std::uint64_t k) const override;
    Status read_luma(std::uint64_t k, ImageView<std::uint8_t> luma) override;
    Status read_depth(std::uint64_t k, ImageView<std::uint16_t> depth) override;
    void read_amplitude(std::uint64_t k, Image<std::uint16_t> &amplitude) override;

private:
    double time_s(std::uint64_t k) const { return static_cast<double>(k) / fps_; }

    RigCalibration rig_;
    double fps_;
    double lag_s_; ///< from an image to the exposure of its depth map
    bool noisy_;
    SyntheticWorld world_;
    Noise noise_;
    Exposure exposure_;
    LensRenderer color_;
    TofCamera tof_;
};

} // namespace afterglow
