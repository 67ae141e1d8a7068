// SPDX-License-Identifier: Apache-2.0
#include "daemon/calibration_notes.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <utility>

namespace afterglow {
namespace {

/// A line, cut off where it has no room.
template <class... Parts>
void note(Outbox &outbox, Priority priority, fmt::format_string<Parts...> format,
          Parts &&...parts) {
    std::array<char, sizeof(Note::text)> line{};
    const auto written =
        fmt::format_to_n(line.data(), line.size(), format, std::forward<Parts>(parts)...);
    outbox.note(priority, {line.data(), std::min(written.size, line.size())});
}

} // namespace

void CalibrationNotes::update(const CalibrationState &calibration, Outbox &outbox) {
    const CalibrationState before = std::exchange(told_, calibration);
    for (std::size_t i = 0; i < calibration_parts; ++i) {
        const auto part = static_cast<CalibrationPart>(i);
        const CalibrationFinding &found = calibration[part], &was = before[part];
        const auto [per_amount, unit] = calibration_unit(part);
        if (found.suspect && !was.suspect)
            note(outbox, Priority::warning,
                 "the calibration is suspect: images and depth disagree as if the {} were wrong by "
                 "{:.2f} {} (deviation {:.2f})",
                 to_string(part), per_amount * found.amount, unit, per_amount * found.deviation);
        if (!found.suspect && was.suspect)
            note(outbox, Priority::info, "the calibration's {} is no longer suspect",
                 to_string(part));
        if (found.corrected != 0 && was.corrected == 0)
            note(outbox, Priority::info,
                 "depth is corrected for the calibration's {} now, by {:.2f} {}", to_string(part),
                 per_amount * found.corrected, unit);
        if (found.corrected == 0 && was.corrected != 0)
            note(outbox, Priority::info, "depth is no longer corrected for the calibration's {}",
                 to_string(part));
    }
}

} // namespace afterglow
