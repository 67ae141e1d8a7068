// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "ipc/bus/event.hpp"

#include <cstdint>
#include <functional>

namespace afterglow {

/// Does something as often as asked, but at most ten times a second: what is asked for too early is
/// done once, when the time has come. So signals are rate-limited, and the last one is never left
/// out. Main thread only.
class Paced {
public:
    static constexpr std::uint64_t period_us = 100'000;

    Paced(sd_event *event, std::function<void()> action);

    void ask();

private:
    static int on_time(sd_event_source *source, std::uint64_t time_us, void *paced);
    void act();

    sd_event *event_; // outlives all that waits on it
    std::function<void()> action_;
    EventSource timer_;
    bool waiting_ = false;
    std::uint64_t next_us_ = 0; ///< CLOCK_MONOTONIC
};

} // namespace afterglow
