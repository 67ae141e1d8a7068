// SPDX-License-Identifier: Apache-2.0
#include "daemon/calibration_notes.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <utility>

namespace afterglow {

void CalibrationNotes::update(const CalibrationState &calibration, Outbox &outbox) {
    const CalibrationState before = std::exchange(told_, calibration);
    for (std::size_t i = 0; i < calibration_parts; ++i) {
        const auto part = static_cast<CalibrationPart>(i);
        const CalibrationFinding &found = calibration[part];
        if (found.suspect == before[part].suspect)
            continue;
        std::array<char, sizeof(Note::text)> line{};
        const auto [unit, unit_name] = calibration_unit(part);
        const auto written =
            found.suspect
                ? fmt::format_to_n(
                      line.data(), line.size(),
                      "the calibration is suspect: images and depth disagree as if the "
                      "{} were wrong by {:.2f} {} (deviation {:.2f})",
                      to_string(part), unit * found.amount, unit_name, unit * found.deviation)
                : fmt::format_to_n(line.data(), line.size(),
                                   "the calibration's {} is no longer suspect", to_string(part));
        outbox.note(found.suspect ? Priority::warning : Priority::info,
                    {line.data(), std::min(written.size, line.size())});
    }
}

} // namespace afterglow
