// SPDX-License-Identifier: Apache-2.0
#include "ipc/bus/paced.hpp"

#include <ctime>
#include <utility>

namespace afterglow {

Paced::Paced(sd_event *event, std::function<void()> action)
    : event_(event), action_(std::move(action)) {
    sd_event_source *timer = nullptr;
    if (sd_event_add_time(event_, &timer, CLOCK_MONOTONIC, 0, 0, on_time, this) >= 0)
        sd_event_source_set_enabled(timer, SD_EVENT_OFF);
    timer_.reset(timer);
}

void Paced::ask() {
    if (waiting_)
        return;
    std::uint64_t now_us = 0;
    sd_event_now(event_, CLOCK_MONOTONIC, &now_us);
    if (now_us >= next_us_ || !timer_) {
        act();
        return;
    }
    waiting_ = true;
    sd_event_source_set_time(timer_.get(), next_us_);
    sd_event_source_set_enabled(timer_.get(), SD_EVENT_ONESHOT);
}

int Paced::on_time(sd_event_source * /*source*/, std::uint64_t /*time_us*/, void *paced) {
    static_cast<Paced *>(paced)->act();
    return 0;
}

void Paced::act() {
    waiting_ = false;
    sd_event_now(event_, CLOCK_MONOTONIC, &next_us_);
    next_us_ += period_us;
    action_();
}

} // namespace afterglow
