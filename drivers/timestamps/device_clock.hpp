// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>

namespace afterglow {

/// Converts the times of a device's own clock to CLOCK_MONOTONIC.
///
///     arrival = device time + offset + drift * device time + transfer,   transfer >= least
///
/// A frame may arrive late, never early; so offset and drift are fitted to the lower envelope of
/// arrival - device time: of every ten seconds the frame with the least delay is kept, and the line
/// runs below the last eight of these. The least transfer time stays unknown: the result is the
/// time at which a frame with the least delay would have arrived.
///
/// When the device clock jumps or restarts, the fit restarts. Real-time safe.
class DeviceClock {
public:
    /// `arrival_ns`: CLOCK_MONOTONIC as the frame came, not earlier than the one before.
    std::int64_t to_monotonic(std::int64_t device_ns, std::int64_t arrival_ns);
    /// How much slower the device's clock runs than the host's, parts per million; 0 while unknown.
    double drift_ppm() const { return slope_ * 1e6; }

private:
    /// Times since the first frame, ns. `excess`: how much longer it is by the host's clock.
    struct Point {
        std::int64_t device = 0;
        std::int64_t excess = 0;
    };

    void restart(std::int64_t device_ns, std::int64_t arrival_ns);
    void add(const Point &point);
    void fit();
    double line(std::int64_t device) const;

    static constexpr std::size_t capacity = 8;

    bool begun_ = false;
    std::int64_t device_base_ = 0;
    std::int64_t arrival_base_ = 0;
    std::int64_t last_device_ = 0;
    std::array<Point, capacity> soonest_{}; ///< of each ten seconds, oldest first
    std::size_t count_ = 0;
    std::int64_t window_begin_ = 0; ///< of the last of them
    int too_late_ = 0;              ///< frames in a row
    double slope_ = 0;
    double offset_ = 0;
};

} // namespace afterglow
