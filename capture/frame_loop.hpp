// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "capture/depth_pairing.hpp"
#include "capture/pair_lag.hpp"
#include "core/gate.hpp"
#include "core/pipeline.hpp"
#include "drivers/source.hpp"

#include <chrono>
#include <cstdint>
#include <optional>
#include <string_view>

namespace afterglow {

/// What one turn of the loop came to.
struct FrameResult {
    Capture capture = Capture::none; ///< of the colour source; the rest holds only for `frame`
    Estimate estimate;               ///< valid until the next turn
    LumaView luma;                   ///< the image; valid until the next turn
    std::int64_t t_ns = 0;           ///< capture time of the image
    std::uint64_t sequence = 0;      ///< the colour source's count
    bool lit = false;                ///< the illuminator may have been on when this image was taken
    bool awaited = false;            ///< it was to be on, so that a measurement could come
    GateReason reason = GateReason::none; ///< why the gate wants it on
    bool budget_spent = false;            ///< it wants it on, and the budget does not allow it
    Capture tof = Capture::none;          ///< of the TOF source
    /// Where `tof` is a frame: when the map was taken, on the images' clock, and its number.
    std::int64_t tof_t_ns = 0;
    std::uint64_t tof_sequence = 0;
    /// Where besides the light had to be switched on: from the image that asked to this one.
    std::optional<std::chrono::nanoseconds> wake_latency;
    std::chrono::nanoseconds estimation_time{}; ///< spent in the pipeline
    std::string_view problem; ///< the sentence behind a `damaged` or `lost`; else empty
    /// Why the light does not obey, which is as bad as a lost TOF camera; empty: it does.
    std::string_view light_problem;
};

/// The way of a frame: image, estimate, gate, light, measurement. The same code runs in the
/// daemon, where its result goes to the ring, and in afterglow-eval, where it is scored.
///
/// Frames that cannot be trusted (of another size, not later than the one before, depth that is
/// all but empty) come out as Capture::damaged and reach nobody.
///
/// Runs on the estimator thread; allocates nothing after it was made while the devices are well.
class FrameLoop {
public:
    /// The rig must outlive the loop; its sources must have been opened, not started. Without
    /// `geometry` depth is registered to the colour camera, which its source tells.
    FrameLoop(Rig &rig, PipelineFactory make, const GatePolicy &gate,
              const std::optional<RigGeometry> &geometry = {});

    /// Another calibration; the sizes of all cameras must be the same. Makes the pipeline anew,
    /// which forgets depth and all that was learnt. Allocates.
    void set_geometry(const RigGeometry &geometry);
    const RigGeometry &geometry() const { return geometry_; }

    /// Starts both sources. On failure neither runs. Depth from before a pause is forgotten; what
    /// was learnt about the cameras, and what has been spent of the budget, stays.
    Status start();
    /// The parts of start(), for a daemon that works on with one camera.
    Status start_color();
    Status start_tof();
    /// Darkens the illuminator and stops both sources.
    void stop();
    /// Darkens the illuminator and stops the TOF source; images go on being tracked.
    void stop_tof();

    /// Waits at most `timeout` for an image and takes it the whole way.
    FrameResult step(std::chrono::nanoseconds timeout);

    Gate &gate() { return gate_; }
    /// Whether anybody reads the confidences of the estimates that come; at first somebody does.
    void want_confidence(bool wanted) { confidence_wanted_ = wanted; }
    /// The longest time between two images with a depth map; 0: every image has one. The images
    /// between them are tracked, and their FrameResult::estimate has no map. An image that is
    /// measured and the image after it always have one.
    void want_depth_every(std::chrono::nanoseconds interval) { depth_interval_ = interval; }

private:
    bool is_trusted(FrameResult &result);
    int images_until_due() const;
    int images_until(std::int64_t t_ns) const;
    /// Lights the TOF camera and takes the measurement for the current image, if there is one.
    void measure(FrameResult &result);
    /// False when the illuminator does not obey; `result` says why.
    bool set_light(bool lit, FrameResult &result);

    Rig &rig_;
    PipelineFactory make_;
    RigGeometry geometry_;
    std::unique_ptr<Pipeline> pipeline_;
    bool confidence_wanted_ = true;
    std::uint32_t earlier_worlds_ = 0; ///< those of the pipelines before, which counted from 1, too
    std::uint32_t last_world_ = 0;     ///< as published
    Gate gate_;
    DepthPairing pairing_;
    PairLag pair_lag_;
    ColorFrame color_;
    std::optional<std::int64_t> last_t_ns_;
    std::chrono::nanoseconds depth_interval_{0};
    std::optional<std::int64_t> due_ns_;   ///< of the last image that was due; none: the next is
    std::optional<std::int64_t> asked_ns_; ///< capture time of the image that asked for light
    std::string light_problem_;
    bool tof_running_ = false;
};

} // namespace afterglow
