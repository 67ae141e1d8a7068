// SPDX-License-Identifier: Apache-2.0
#include "core/gate.hpp"

#include <algorithm>
#include <array>
#include <utility>

namespace afterglow {
namespace {

constexpr std::array<std::pair<GateMode, std::string_view>, 4> mode_names{{
    {GateMode::automatic, "auto"},
    {GateMode::always_on, "always-on"},
    {GateMode::interval, "interval"},
    {GateMode::off, "off"},
}};

// In the order of enum GateReason.
constexpr std::array<std::string_view, 10> reason_names{"dark",      "first",    "lost", "error",
                                                        "saving",    "coverage", "age",  "interval",
                                                        "always-on", "requested"};

/// Carrying a map for one image is taken to have added this share of its error, at least.
constexpr double least_carried = 0.1;
/// A light that is kept on goes out after so many times the images that waking takes: only a map
/// that is carried in the dark shows how its error grows.
constexpr int longest_kept = 8;

} // namespace

std::string_view to_string(GateReason reason) {
    return reason_names[static_cast<std::size_t>(reason)];
}

std::string_view to_string(GateMode mode) {
    for (const auto &[value, name] : mode_names)
        if (value == mode)
            return name;
    return {};
}

std::optional<GateMode> gate_mode_from_string(std::string_view name) {
    for (const auto &[value, known] : mode_names)
        if (known == name)
            return value;
    return std::nullopt;
}

void Gate::set_policy(const GatePolicy &policy) {
    kept_ = kept_ && policy.mode == policy_.mode;
    policy_ = policy;
}

void Gate::restart() {
    since_measurement_ = -1;
    waited_ = -1;
    kept_ = false;
    reason_ = GateReason::none;
    budget_spent_ = false;
}

bool Gate::wants_light(const Estimate &estimate, bool ready, const FrameSchedule &frames) {
    if (since_measurement_ >= 0)
        ++since_measurement_;
    last_mre_ = estimate.expected_mre + estimate.moved_mre;
    last_independent_ = estimate.independent_mre + estimate.moved_mre;
    if (frames.now) {
        frame_at_ = since_measurement_;
        frame_interval_ = frames.next_in;
    }
    fresh_mre_ = estimate.fresh_mre;
    lost_ = estimate.wants_measurement;
    // A map that was lost tells nothing of how errors grow. Others may follow without a
    // measurement, where the budget is spent.
    if (!lost_ && since_measurement_ > 0) {
        if (first_at_ == 0) {
            first_at_ = since_measurement_;
            first_mre_ = last_mre_;
            first_independent_ = last_independent_;
            first_coverage_ = estimate.relative_coverage;
            excess_ = 0;
        }
        excess_ += excess_of(last_independent_);
    }
    tokens_ = std::min(tokens_ + policy_.duty_cycle_budget / 100, policy_.budget_burst);
    if (!ready || policy_.mode == GateMode::off)
        waited_ = -1;
    if (waited_ < 0)
        reason_ = decide(estimate, frames);
    budget_spent_ = waited_ < 0 && reason_ != GateReason::none && exhausted_;
    if (!ready || budget_spent_)
        reason_ = GateReason::none;
    const bool lit = reason_ != GateReason::none;
    kept_ = kept_ && lit;
    waited_ = lit ? waited_ + 1 : -1;
    if (lit)
        --tokens_; // a wake that had begun may overdraw them
    exhausted_ = policy_.duty_cycle_budget < 100 &&
                 (exhausted_ ? tokens_ < policy_.budget_burst / 2 : tokens_ < 1);
    return lit;
}

void Gate::measured() {
    if (!kept_)
        latency_ = std::max(waited_, 0);
    if (is_carried_on() && !lost_) {
        const double least = least_carried * first_independent_;
        growth_ = first_independent_ > 0 ? growth_per_image() / std::max(carried(), least) : 0;
    }
    kept_images_ = kept_ ? kept_images_ + since_measurement_ : 0;
    kept_ = !exhausted_ && (policy_.mode == GateMode::always_on ||
                            (policy_.mode == GateMode::automatic && wakes_too_late()));
    since_measurement_ = frame_at_ = first_at_ = 0;
    waited_ = -1;
    requested_ = false;
}

/// Why this image wants light, whatever the budget says.
GateReason Gate::decide(const Estimate &estimate, const FrameSchedule &frames) const {
    if (policy_.mode == GateMode::off)
        return GateReason::none;
    if (since_measurement_ < 0)
        return GateReason::first;
    if (requested_)
        return GateReason::requested;
    if (kept_ && policy_.mode == GateMode::automatic)
        return GateReason::error;
    switch (policy_.mode) {
    case GateMode::automatic:
        return decide_automatic(estimate, frames);
    case GateMode::always_on:
        return GateReason::always_on;
    case GateMode::interval:
        return since_measurement_ + latency_ >= policy_.interval_frames ? GateReason::interval
                                                                        : GateReason::none;
    case GateMode::off:
        break;
    }
    return GateReason::none;
}

GateReason Gate::decide_automatic(const Estimate &estimate, const FrameSchedule &frames) const {
    const int arrival = since_measurement_ + latency_;
    if (arrival < policy_.shortest_interval_frames)
        return GateReason::none;
    if (estimate.wants_measurement)
        return GateReason::lost;
    if (arrival >= policy_.longest_interval_frames || too_old(estimate))
        return GateReason::age;
    return judge_map(estimate, frames);
}

/// Whether the map would be older than allowed by the time a measurement could arrive.
bool Gate::too_old(const Estimate &estimate) const {
    if (policy_.longest_age_ms <= 0 || estimate.age_frames == 0)
        return false;
    const double age_ms = 1e-6 * static_cast<double>(estimate.age_ns);
    return age_ms * (1 + static_cast<double>(latency_) / estimate.age_frames) >
           policy_.longest_age_ms;
}

/// By how much the squared error is more than that of a map just measured; percent^2. A measurement
/// does not remove errors of the TOF camera that are correlated between near views.
double Gate::excess_of(double independent_mre) const {
    const double first = first_independent_;
    return std::max(independent_mre * independent_mre - first * first, 0.0);
}

/// What carrying a map for one image has added to a fresh one's error, percent.
double Gate::carried() const {
    return std::max(first_independent_ - fresh_mre_, 0.0);
}

/// Whether a measurement would be worth its light at this independent_mre, percent.
bool Gate::would_help(double independent_mre) const {
    return fresh_mre_ < policy_.worthwhile / 100 * independent_mre;
}

/// By how much the error grows from image to image, percent: as it has since the first map after
/// the measurement, or, where no other has been made, as with the measurement before.
double Gate::growth_per_image() const {
    return is_carried_on()
               ? std::max(last_independent_ - first_independent_, 0.0) / (frame_at_ - first_at_)
               : growth_ * carried();
}

/// Whether the map will be too wrong or too small by the time a measurement could arrive: error and
/// coverage are expected to go on as they went since the last measurement.
GateReason Gate::judge_map(const Estimate &estimate, const FrameSchedule &frames) const {
    if (estimate.expected_mre < 0)
        return GateReason::none;
    // Between frames that are further apart than waking takes, light is asked for when a
    // measurement would come with the next one. A frame that is too wrong already does not wait.
    const bool in_time =
        frames.now ? latency_ == 0 || frames.next_in <= latency_ : frames.next_in == latency_;
    if (!frames.now && !in_time)
        return GateReason::none;
    const int ahead = in_time ? since_measurement_ - frame_at_ + latency_ : 0;
    const double growth = ahead * growth_per_image();
    const double lost =
        is_carried_on()
            ? std::max(first_coverage_ - estimate.relative_coverage, 0.0) / (frame_at_ - first_at_)
            : 0.0;
    const double coverage = estimate.relative_coverage - ahead * lost;
    if (last_mre_ + growth > policy_.target_mre && would_help(last_independent_ + growth))
        return GateReason::error;
    if (in_time && pays_off(growth))
        return GateReason::saving;
    return coverage < policy_.coverage_floor ? GateReason::coverage : GateReason::none;
}

/// Measured every n images at a price p, an image costs (sum_i e_i^2 + p) / n in the mean. That is
/// least where the next image would cost more than this mean. e_i^2: excess_of() image i.
/// `growth`: of the error until a measurement could arrive, percent.
bool Gate::pays_off(double growth) const {
    const double price = policy_.measurement_price * policy_.target_mre * policy_.target_mre;
    const double now = excess_of(last_independent_);
    const double at_arrival = excess_of(last_independent_ + growth);
    const double until_arrival = latency_ * (now + at_arrival) / 2;
    const int frames = since_measurement_ + latency_;
    return price > 0 && frames * at_arrival - excess_ - until_arrival >= price;
}

/// Whether the next map would be too wrong by the time that a TOF camera which goes dark now could
/// measure again. A map's error is expected to grow as the last one's that was carried in the dark;
/// less, if carrying it for one image adds less. It wakes in time if no other frame than the first
/// is due until then.
bool Gate::wakes_too_late() const {
    if (latency_ <= frame_interval_ || policy_.shortest_interval_frames > 1 ||
        kept_images_ >= longest_kept * latency_)
        return false;
    const double growth = latency_ * growth_ * carried();
    return first_mre_ + growth > policy_.target_mre && would_help(first_independent_ + growth);
}

} // namespace afterglow
