// SPDX-License-Identifier: Apache-2.0
#include "drivers/timestamps/device_clock.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

namespace afterglow {
namespace {

constexpr std::int64_t window_ns = 10'000'000'000;
/// No crystal is further off.
constexpr double most_drift = 500e-6;
/// A frame so much earlier than any could be, or several so much later, are of a clock that jumped.
constexpr double early_jump_ns = 50e6;
constexpr double late_jump_ns = 500e6;
constexpr int late_jump_frames = 5;

} // namespace

std::int64_t DeviceClock::to_monotonic(std::int64_t device_ns, std::int64_t arrival_ns) {
    if (!begun_ || device_ns < last_device_)
        restart(device_ns, arrival_ns);
    Point point = {device_ns - device_base_,
                   (arrival_ns - arrival_base_) - (device_ns - device_base_)};
    const double late_by = static_cast<double>(point.excess) - line(point.device);
    too_late_ = late_by > late_jump_ns ? too_late_ + 1 : 0;
    if (late_by < -early_jump_ns || too_late_ >= late_jump_frames) {
        restart(device_ns, arrival_ns);
        point = {};
    }
    last_device_ = device_ns;
    add(point);
    fit();
    return arrival_base_ + point.device + std::llround(line(point.device));
}

void DeviceClock::restart(std::int64_t device_ns, std::int64_t arrival_ns) {
    *this = DeviceClock();
    begun_ = true;
    device_base_ = device_ns;
    arrival_base_ = arrival_ns;
}

void DeviceClock::add(const Point &point) {
    if (count_ == 0 || point.device - window_begin_ >= window_ns) {
        if (count_ == capacity)
            std::copy(soonest_.begin() + 1, soonest_.end(), soonest_.begin());
        else
            ++count_;
        window_begin_ = point.device;
        soonest_[count_ - 1] = point;
    } else if (static_cast<double>(point.excess) - line(point.device) <
               static_cast<double>(soonest_[count_ - 1].excess) -
                   line(soonest_[count_ - 1].device)) {
        soonest_[count_ - 1] = point;
    }
}

/// The line through the first and the last of the points, lowered until none lies below it. The
/// ten seconds that have not passed yet may not have had a swift frame, and say nothing of drift.
void DeviceClock::fit() {
    if (count_ >= 3) {
        const Point &first = soonest_[0];
        const Point &last = soonest_[count_ - 2];
        slope_ = std::clamp(static_cast<double>(last.excess - first.excess) /
                                static_cast<double>(last.device - first.device),
                            -most_drift, most_drift);
    }
    double lowest = std::numeric_limits<double>::max();
    for (std::size_t i = 0; i < count_; ++i)
        lowest = std::min(lowest, static_cast<double>(soonest_[i].excess) -
                                      slope_ * static_cast<double>(soonest_[i].device));
    offset_ = lowest;
}

double DeviceClock::line(std::int64_t device) const {
    return offset_ + slope_ * static_cast<double>(device);
}

} // namespace afterglow
