// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "ipc/bus/bus.hpp"
#include "ipc/bus/event.hpp"
#include "ipc/bus/situation.hpp"

#include <cstdint>
#include <functional>
#include <list>
#include <string>

namespace afterglow {

/// The calls of Measure() that wait for their frame: until it comes, until it is clear that it will
/// not, or for `longest_wait_us`. Main thread only.
class MeasureCalls {
public:
    static constexpr std::size_t most_of_a_sender = 8;
    static constexpr std::size_t most_calls = 64;
    static constexpr std::uint64_t longest_wait_us = 5'000'000;

    /// `measure` orders a measurement.
    MeasureCalls(sd_event *event, std::function<void()> measure);

    /// Takes a call, or answers it with an error at once. Returns as a handler of sd-bus does.
    int take(sd_bus_message *call, const Situation &situation);
    /// Answers those that wait, where the situation decides; called when it has changed.
    void judge(const Situation &situation);
    /// The connection is lost: nobody waits any more.
    void clear() { calls_.clear(); }

private:
    struct Call {
        MeasureCalls &owner;
        BusMessage message;
        std::int64_t since_ns; ///< CLOCK_MONOTONIC
        EventSource timeout;
    };
    static int on_timeout(sd_event_source *source, std::uint64_t time_us, void *call);

    sd_event *event_; // outlives all that waits on it
    std::function<void()> measure_;
    std::list<Call> calls_;
};

} // namespace afterglow
