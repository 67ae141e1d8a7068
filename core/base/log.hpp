// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string_view>

namespace afterglow {

/// The syslog levels that are used.
enum class Priority { error = 3, warning = 4, info = 6 };

/// Where lines go, and how they begin.
enum class LogTarget {
    console, ///< standard error; with the program's name
    journal, ///< standard error, which the journal reads; with the syslog level ("<3>")
    null,    ///< nowhere
};

// Any thread. At the start: everything, and what standard error is.

/// The least urgent syslog level that is written, 0 to 7.
int log_level() noexcept;
void set_log_level(int level) noexcept;

LogTarget log_target() noexcept;
/// False: standard error is not the journal's, and `target` is; nothing changes.
bool set_log_target(LogTarget target) noexcept;

/// Writes one line where log_target() says, if log_level() lets it. A line that cannot be written
/// (standard error is closed, full or a broken pipe) is lost; nothing is thrown. Any thread but the
/// estimator thread: it allocates and may wait for the reader.
void log(Priority priority, std::string_view sentence) noexcept;

} // namespace afterglow
