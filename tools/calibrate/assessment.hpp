// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "tools/calibrate/coverage.hpp"
#include "tools/calibrate/rig_fit.hpp"
#include "tools/calibrate/timing_fit.hpp"

#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <vector>

namespace afterglow {

enum class Verdict : std::uint8_t { good, usable, not_usable };
const char *to_text(Verdict verdict);

/// What a calibration is worth, and what would make it better.
struct Assessment {
    Verdict verdict = Verdict::good;
    std::vector<std::string> reasons; ///< why it is not good, and what to do; a sentence each
};

/// `timing`: nothing where no moving board was recorded. `views`: those of the fit.
Assessment assess(const RigFit &fit, const Board &board, std::span<const BoardView> views,
                  const std::optional<TimingFit> &timing);

/// Of the colour camera's view, and of the TOF camera's by its amplitude.
Coverage color_coverage(const RigFit &fit, std::span<const BoardView> views);
Coverage tof_coverage(const RigFit &fit, std::span<const BoardView> views);

} // namespace afterglow
