// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <string_view>

namespace afterglow {

/// `text` as it may stand in a message on a terminal or in a log: on one line, without control
/// characters, at most about 200 bytes. Control characters and bytes that are not UTF-8 become
/// "\n", "\t" or "\x1b"; of a longer text the middle is replaced by "...".
std::string printable(std::string_view text);

} // namespace afterglow
