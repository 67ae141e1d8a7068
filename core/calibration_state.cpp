// SPDX-License-Identifier: Apache-2.0
#include "core/calibration_state.hpp"

#include "core/base/degrees.hpp"

namespace afterglow {

std::string_view to_string(CalibrationPart part) {
    switch (part) {
    case CalibrationPart::rotation:
        return "rotation";
    case CalibrationPart::translation:
        return "translation";
    case CalibrationPart::focal_length:
        return "focal-length";
    case CalibrationPart::lag:
        break;
    }
    return "lag";
}

CalibrationUnit calibration_unit(CalibrationPart part) {
    switch (part) {
    case CalibrationPart::rotation:
        return {degrees_per_radian, "degrees"};
    case CalibrationPart::translation:
        return {1e3, "mm"};
    case CalibrationPart::focal_length:
        return {100, "percent"};
    case CalibrationPart::lag:
        break;
    }
    return {1e3, "ms"};
}

} // namespace afterglow
