// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "core/base/result.hpp"

#include <string>

namespace afterglow {

/// Writes `text` to a new file and prints its path; prints the text itself if `path` is empty. As
/// JSON, `what` is the text's key beside that of the path. Gives 0, as an Action does. Errors: the
/// file is there already, so that nothing that somebody has written is lost, or cannot be written.
Result<int> print_or_write(const char *what, const std::string &text, const std::string &path,
                           bool json);

} // namespace afterglow
