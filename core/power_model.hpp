// SPDX-License-Identifier: Apache-2.0
#pragma once

namespace afterglow {

/// Power of depth sensing, watts:
///
///     P = d P_TOF + P_idle + c P_core
///
/// d: share of the frames lit. c: CPU seconds that the process uses for each second of the stream,
/// measured; it may be above 1. The defaults are those of Noraky & Sze 2019, Table VI, an ODROID
/// XU3: with four busy Cortex-A7 cores (c = 4) the processor and memory take its 0.63 + 0.06 W.
/// Nothing is charged for the image camera, nor while the cameras sleep.
struct PowerModel {
    double tof_w = 5.0;    ///< P_TOF, 1 to 5 W for commercial cameras
    double idle_w = 0.19;  ///< P_idle, processor and memory that do nothing: 0.16 + 0.03
    double core_w = 0.125; ///< P_core, what a busy core adds: (0.63 + 0.06 - idle_w) / 4

    bool operator==(const PowerModel &) const = default;

    /// P. `duty_cycle`: d, 0..1. `cpu_load`: c.
    double system_w(double duty_cycle, double cpu_load) const {
        return duty_cycle * tof_w + idle_w + cpu_load * core_w;
    }
};

} // namespace afterglow
