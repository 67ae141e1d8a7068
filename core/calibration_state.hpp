// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <string_view>

namespace afterglow {

/// What can be wrong with the calibration of two cameras.
enum class CalibrationPart : std::uint8_t { rotation, translation, focal_length, lag };
constexpr std::size_t calibration_parts = 4;
/// "rotation", "translation", "focal-length", "lag".
std::string_view to_string(CalibrationPart part);

/// How amounts of a part are told to people.
struct CalibrationUnit {
    double per_amount; ///< of CalibrationFinding
    std::string_view name;
};
/// degrees, millimetres, percent, milliseconds.
CalibrationUnit calibration_unit(CalibrationPart part);

/// How far a part of the calibration is off, as images and depth say.
struct CalibrationFinding {
    /// rotation: radians, translation: metres, both lengths of vectors; focal_length: share by
    /// which the colour camera's is too short against the TOF camera's; lag: seconds by which depth
    /// maps are exposed later than their stamps say.
    float amount = 0;
    float deviation = 0; ///< of the amount, one sigma
    bool suspect = false;
    /// Measured depth is corrected by so much of the amount now; 0: not at all.
    float corrected = 0;
};

/// The calibration as the last measurements show it.
struct CalibrationState {
    std::array<CalibrationFinding, calibration_parts> parts{};

    const CalibrationFinding &operator[](CalibrationPart part) const {
        return parts[static_cast<std::size_t>(part)];
    }
    CalibrationFinding &operator[](CalibrationPart part) {
        return parts[static_cast<std::size_t>(part)];
    }
    bool suspect() const {
        return std::ranges::any_of(parts, [](const CalibrationFinding &f) { return f.suspect; });
    }
};

} // namespace afterglow
