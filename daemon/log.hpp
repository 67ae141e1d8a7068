// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string_view>

namespace afterglow {

/// The syslog levels that the daemon uses.
enum class Priority { error = 3, warning = 4, info = 6 };

/// One line to stderr: with the level in front where the journal listens, with the program's name
/// where a person does. Never from the estimator thread.
void log(Priority priority, std::string_view sentence);

} // namespace afterglow
