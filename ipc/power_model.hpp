// SPDX-License-Identifier: Apache-2.0
#pragma once

namespace afterglow {

/// Power of depth sensing with and without afterglow (Noraky & Sze 2019, Section VI, Eq. 9), watts.
/// The defaults are the paper's measurements of an ODROID XU-3.
struct PowerModel {
    double tof_w = 5.0;      ///< P_TOF, 1 to 5 W for commercial cameras
    double idle_w = 0.19;    ///< P_I, cores and memory while the TOF camera measures
    double compute_w = 0.63; ///< P_C, cores while estimating
    double memory_w = 0.06;  ///< P_M, memory while estimating

    /// P_S at `duty_cycle` (ON / 100 in the paper), 0..1.
    double system_w(double duty_cycle) const {
        return duty_cycle * (tof_w + idle_w) + (1.0 - duty_cycle) * (compute_w + memory_w);
    }
    /// Share of the TOF camera's own power that is saved; negative when estimating costs more.
    double saving(double duty_cycle) const { return 1.0 - system_w(duty_cycle) / tof_w; }
};

} // namespace afterglow
