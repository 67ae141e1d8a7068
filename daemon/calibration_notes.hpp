// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "core/calibration_state.hpp"
#include "daemon/outbox.hpp"

namespace afterglow {

/// Puts a line into the log when a part of the calibration becomes suspect or is corrected, and
/// when it no longer is. Real-time safe.
class CalibrationNotes {
public:
    void update(const CalibrationState &calibration, Outbox &outbox);

private:
    CalibrationState told_;
};

} // namespace afterglow
