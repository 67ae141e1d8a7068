// SPDX-License-Identifier: Apache-2.0
#include "drivers/simulated/rounds.hpp"

#include "drivers/simulated/replay.hpp"

#include <algorithm>
#include <cmath>

namespace afterglow {

Rounds::Rounds(const Recording &recording, double speed)
    : length_ns_(std::llround(static_cast<double>(round_length_ns(recording)) / speed)) {
    for (const Recording::Entry &entry : recording.entries)
        offsets_ns_.push_back(std::llround(
            static_cast<double>(entry.t_color_ns - recording.entries[0].t_color_ns) / speed));
}

Rounds::Frame Rounds::next(std::int64_t t_ns) const {
    const std::int64_t round = t_ns / length_ns_ * length_ns_;
    const auto after = std::upper_bound(offsets_ns_.begin(), offsets_ns_.end(), t_ns - round);
    if (after == offsets_ns_.end())
        return {round + length_ns_, 0};
    return {round + *after, static_cast<std::uint64_t>(after - offsets_ns_.begin())};
}

} // namespace afterglow
