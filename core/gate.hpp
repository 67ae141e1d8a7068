// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "core/estimate.hpp"

#include <cstdint>
#include <optional>
#include <string_view>

namespace afterglow {

/// Who decides when the TOF camera is lit.
enum class GateMode : std::uint8_t {
    automatic = 0, ///< the expected error and coverage of the estimates
    always_on = 1, ///< every frame is measured
    interval = 2,  ///< every `interval_frames`th frame is measured (Noraky 2017)
    off = 3,       ///< the illuminator stays dark, whatever that costs
};

/// "auto", "always-on", "interval" or "off": the names in configuration and on D-Bus.
std::string_view to_string(GateMode mode);
std::optional<GateMode> gate_mode_from_string(std::string_view name);

/// Why the TOF camera is lit.
enum class GateReason : std::uint8_t {
    none,      ///< it is dark
    first,     ///< there is no measurement yet
    lost,      ///< the camera's motion is not known any more
    error,     ///< the expected error passes the target
    saving,    ///< the target is still met, but a measurement saves more error than it costs
    coverage,  ///< too little of the map is left
    age,       ///< the map would be too old
    interval,  ///< it is time, by GateMode::interval
    always_on, ///< GateMode::always_on
    requested, ///< somebody asked for a measurement
};

/// "error", "always-on": the names on D-Bus. "dark" for none.
std::string_view to_string(GateReason reason);

struct GatePolicy {
    GateMode mode = GateMode::automatic;
    int interval_frames = 10; ///< for GateMode::interval; 1 measures every frame

    // For GateMode::automatic.
    double target_mre = 2; ///< percent: light when a frame is expected to pass this error
    /// Frames at that error whose squared errors sum up to what a measurement costs: light, too,
    /// when a measurement saves more. 0: the target alone decides.
    double measurement_price = 1.4;
    double worthwhile = 75;     ///< percent: a measurement must promise to lower it to this share
    double coverage_floor = 75; ///< percent of what a measurement would cover
    int shortest_interval_frames = 1;  ///< between two measurements, at least
    int longest_interval_frames = 300; ///< and at most
    /// Milliseconds since the measurement that a published map rests on, at most; 0: no limit.
    double longest_age_ms = 0;

    // For every mode.
    /// Percent of the frames that may be lit in the long run; 100 = no budget. `budget_burst`
    /// frames may be saved up; once they are spent, light waits until half of them are back.
    double duty_cycle_budget = 100;
    double budget_burst = 6;

    bool operator==(const GatePolicy &) const = default;
};

/// Which images have a depth map: not all need one (FrameLoop::want_depth_every()).
struct FrameSchedule {
    bool now = true; ///< this image has one, of which its estimate tells the error
    int next_in = 1; ///< images from this one to the next of which one is due
};

/// Decides for each image whether the illuminator should be lit.
///
/// A preset that predicts its error is lit when the error or the coverage expected *at the time a
/// measurement could arrive* misses the policy, if a measurement would help; one that does not (the
/// paper's) when it asks for a measurement. How long measurements take to arrive is learnt from
/// those that came. A TOF camera that is slow to wake stays lit while the target would be missed by
/// the time that it could measure again. Real-time safe.
class Gate {
public:
    explicit Gate(const GatePolicy &policy) : policy_(policy), tokens_(policy.budget_burst) {}

    /// Holds from the next image on. What has been spent of the budget stays spent.
    void set_policy(const GatePolicy &policy);
    const GatePolicy &policy() const { return policy_; }
    /// Light for the next measurement, in every mode but GateMode::off.
    void request_measurement() { requested_ = true; }
    /// The cameras have paused: there is no measurement any more. The budget stays as it is.
    void restart();

    /// Called once for each image, with its estimate; `ready`: the TOF camera could be lit. Once
    /// it has asked for light it goes on asking until measured() is called, so that a TOF camera
    /// slow to wake is waited for. `frames`: between frames that are more than the wake latency
    /// apart, light is asked for so that the measurement comes with the next one.
    bool wants_light(const Estimate &estimate, bool ready = true, const FrameSchedule &frames = {});
    /// Why the last image wanted light.
    GateReason reason() const { return reason_; }
    /// The last image wanted light, and the budget did not allow it.
    bool budget_spent() const { return budget_spent_; }
    /// A measurement for the current image has arrived.
    void measured();
    /// After measured(): whether the light should stay on until the next image is asked about.
    bool keeps_light() const { return kept_; }
    /// Images from light on to the first measurement, when last seen.
    int wake_latency_frames() const { return latency_; }

private:
    GateReason decide(const Estimate &estimate, const FrameSchedule &frames) const;
    GateReason decide_automatic(const Estimate &estimate, const FrameSchedule &frames) const;
    double carried() const;
    double growth_per_image() const;
    double excess_of(double independent_mre) const;
    /// Whether there are two maps since the measurement that tell how errors grow.
    bool is_carried_on() const { return first_at_ > 0 && frame_at_ > first_at_; }
    bool would_help(double independent_mre) const;
    GateReason judge_map(const Estimate &estimate, const FrameSchedule &frames) const;
    bool too_old(const Estimate &estimate) const;
    bool pays_off(double growth) const;
    bool wakes_too_late() const;

    GatePolicy policy_;
    int since_measurement_ = -1; ///< images; -1: never measured
    int frame_at_ = 0;           ///< since_measurement_ of the last image with a depth map
    int first_at_ = 0;           ///< that of the first image that was not lost; 0: none yet
    int frame_interval_ = 1;     ///< images from that one to the next of which one was due
    int waited_ = -1;            ///< images since the light was asked for; -1: it was not
    int latency_ = 0;
    bool kept_ = false;   ///< the light was to stay on after the last measurement, and did
    int kept_images_ = 0; ///< for how many images it has
    double tokens_;       ///< lit frames that the budget allows now
    bool exhausted_ = false;
    bool requested_ = false;
    GateReason reason_ = GateReason::none;
    bool budget_spent_ = false;
    // Percent: expected_mre and moved_mre of the first estimate since the measurement that was not
    // lost, and of the last one; the same with independent_mre; relative coverage of the first;
    // fresh_mre of the last.
    double first_mre_ = 0, last_mre_ = 0;
    double first_independent_ = 0, last_independent_ = 0;
    double first_coverage_ = 0;
    double fresh_mre_ = 0;
    double excess_ = 0; ///< sum of excess_of() since the measurement
    bool lost_ = false; ///< the last image had no usable estimate
    /// By how much more the error grew from image to image, when last seen, as a share of what
    /// carrying a map for one image adds to a fresh one's.
    double growth_ = 0;
};

} // namespace afterglow
