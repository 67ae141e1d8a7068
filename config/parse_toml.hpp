// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <toml++/toml.h>

#include <algorithm>
#include <cstddef>
#include <string_view>

namespace afterglow {

inline constexpr std::size_t largest_toml_file = 1 << 20; ///< bytes

/// toml::parse() for files that nobody has checked. Throws toml::parse_error.
///
/// toml++ 3.3 bounds how deep values are nested in each other, but not how many parts a dotted key
/// has, and goes through its tables recursively: some ten thousand parts overflow the stack.
inline toml::table parse_toml(std::string_view text) {
    constexpr auto most_dots = 4096; // our files have some hundred, comments included
    if (std::count(text.begin(), text.end(), '.') > most_dots)
        throw toml::parse_error("more dots than any file of this kind has",
                                toml::source_region{{1, 1}, {1, 1}, nullptr});
    return toml::parse(text);
}

} // namespace afterglow
