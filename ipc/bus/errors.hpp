// SPDX-License-Identifier: Apache-2.0
#pragma once

// The names of the errors of org.afterglow.Depth1, besides those of the bus itself.

namespace afterglow {

inline constexpr const char *error_busy = "org.afterglow.Error.Busy";
inline constexpr const char *error_out_of_range = "org.afterglow.Error.OutOfRange";
inline constexpr const char *error_not_running = "org.afterglow.Error.NotRunning";
inline constexpr const char *error_budget_spent = "org.afterglow.Error.BudgetSpent";
inline constexpr const char *error_dark = "org.afterglow.Error.Dark";
inline constexpr const char *error_timed_out = "org.afterglow.Error.TimedOut";
inline constexpr const char *error_no_policy_file = "org.afterglow.Error.NoPolicyFile";
inline constexpr const char *error_bad_configuration = "org.afterglow.Error.BadConfiguration";

} // namespace afterglow
