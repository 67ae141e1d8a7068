// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string_view>

namespace afterglow {

/// The syslog levels that are used.
enum class Priority { error = 3, warning = 4, info = 6 };

/// Writes one line to standard error: with the syslog level in front ("<3>") when the journal
/// reads it, otherwise with the program's name. A line that cannot be written (standard error is
/// closed, full or a broken pipe) is lost; nothing is thrown. Any thread but the estimator thread:
/// it allocates and may wait for the reader.
void log(Priority priority, std::string_view sentence) noexcept;

} // namespace afterglow
