// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "core/keyframe/keyframe_pipeline.hpp"
#include "core/pipeline.hpp"
#include "core/rig/depth_resampler.hpp"
#include "core/rig/luma_resampler.hpp"
#include "core/rig/rig_geometry.hpp"

namespace afterglow {

/// Preset "default" for two cameras with lenses of their own: images and measured maps are brought
/// to the pinhole cameras that KeyframePipeline works in, each at the place of the camera it comes
/// from, and what it composes is brought to the published camera. Where that is the TOF camera,
/// measured maps are published reading by reading. Real-time safe after construction.
class RigPipeline final : public Pipeline {
public:
    RigPipeline(const KeyframeOptions &options, const RigGeometry &geometry, WorkerPool &pool);

    const Estimate &track(LumaView luma, std::int64_t t_ns) override;
    const Estimate &measure(const Measurement &measurement) override;
    void expect_lag(double lag_s) override { pipeline_.expect_lag(lag_s); }
    void prepare() override { pipeline_.prepare(); }
    void restart() override { pipeline_.restart(); }
    void want_confidence(bool wanted) override { pipeline_.want_confidence(wanted); }
    void want_depth(bool wanted) override { pipeline_.want_depth(wanted); }

private:
    RigPipeline(const KeyframeOptions &options, const RigGeometry &geometry, const Views &views,
                WorkerPool &pool);
    const Estimate &publish(const Estimate &composed);
    void lay_over(DepthView readings);
    /// Of the published pixels.
    float percent(int pixels) const {
        return 100 * static_cast<float>(pixels) /
               static_cast<float>(depth_.width() * depth_.height());
    }

    WorkerPool &pool_;
    const bool publishes_readings_;
    LumaResampler color_;
    TofReadings readings_;
    DepthResampler tof_;
    DepthMap surface_;               ///< the measured map as KeyframePipeline takes it
    Image<std::uint16_t> amplitude_; ///< of its light
    KeyframePipeline pipeline_;
    DepthResampler published_;
    DepthMap depth_;
    Image<std::uint8_t> confidence_;
    Estimate estimate_;
};

} // namespace afterglow
