// SPDX-License-Identifier: Apache-2.0
#include "ipc/bus/measure_calls.hpp"

#include "ipc/bus/call_copy.hpp"
#include "ipc/bus/errors.hpp"

#include <algorithm>
#include <chrono>
#include <cstring>
#include <ctime>
#include <utility>

namespace afterglow {
namespace {

/// Why no measurement can come; null: one can.
struct Refusal {
    const char *error = nullptr;
    const char *sentence = nullptr;
};

Refusal refusal_of(const Situation &situation) {
    if (situation.mode == GateMode::off)
        return {error_dark, "Mode off keeps the light dark."};
    const auto &[color, tof] = situation.cameras;
    if (color != CameraState::running && color != CameraState::starting)
        return {error_not_running, "The cameras do not run: open a stream first."};
    if (tof == CameraState::lost)
        return {error_not_running, "The TOF camera is lost."};
    if (situation.budget_spent())
        return {error_budget_spent, "The duty-cycle budget is spent; try again later."};
    return {};
}

} // namespace

MeasureCalls::MeasureCalls(sd_event *event, std::function<void()> measure)
    : event_(event), measure_(std::move(measure)) {}

int MeasureCalls::take(sd_bus_message *call, const Situation &situation) {
    if (const Refusal refusal = refusal_of(situation); refusal.error != nullptr)
        return sd_bus_reply_method_errorf(call, refusal.error, "%s", refusal.sentence);
    const char *sender = sd_bus_message_get_sender(call);
    const auto of_sender = std::count_if(calls_.begin(), calls_.end(), [&](const Call &other) {
        return std::strcmp(sd_bus_message_get_sender(other.message.get()), sender) == 0;
    });
    if (calls_.size() >= most_calls || std::cmp_greater_equal(of_sender, most_of_a_sender))
        return sd_bus_reply_method_errorf(call, error_busy, "%zu calls wait for a measurement.",
                                          calls_.size());
    BusMessage kept;
    if (const int error = copy_call(call, kept); error < 0)
        return error;
    const auto now = std::chrono::steady_clock::now().time_since_epoch();
    Call &taken = calls_.emplace_back(
        Call{*this, std::move(kept),
             std::chrono::duration_cast<std::chrono::nanoseconds>(now).count(), nullptr});
    sd_event_source *timer = nullptr;
    if (const int error = sd_event_add_time_relative(event_, &timer, CLOCK_MONOTONIC,
                                                     longest_wait_us, 0, on_timeout, &taken);
        error < 0) {
        calls_.pop_back();
        return error;
    }
    taken.timeout.reset(timer);
    measure_();
    return 1;
}

void MeasureCalls::judge(const Situation &situation) {
    if (calls_.empty())
        return;
    const Refusal refusal = refusal_of(situation);
    calls_.remove_if([&](const Call &call) {
        if (refusal.error != nullptr) {
            sd_bus_reply_method_errorf(call.message.get(), refusal.error, "%s", refusal.sentence);
            return true;
        }
        const bool measured = situation.frame &&
                              situation.frame->frame.source == AFTERGLOW_MEASURED &&
                              situation.frame->frame.published_ns >= call.since_ns;
        if (measured)
            sd_bus_reply_method_return(call.message.get(), "t", situation.frame->frame.index);
        return measured;
    });
}

int MeasureCalls::on_timeout(sd_event_source *source, std::uint64_t /*time_us*/, void *call) {
    auto &late = *static_cast<Call *>(call);
    sd_bus_reply_method_errorf(late.message.get(), error_timed_out,
                               "No measurement came within 5 s.");
    late.owner.calls_.remove_if([&](const Call &other) { return other.timeout.get() == source; });
    return 0;
}

} // namespace afterglow
