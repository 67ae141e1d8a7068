// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <initializer_list>
#include <optional>
#include <string>
#include <utility>
#include <vector>

namespace afterglow {

// JSON is written value by value: each of these gives the text of one.

/// Text may hold anything, as names of folders do.
std::string json_string(const std::string &text);
/// Four digits after the point; null for nothing and for what is not finite.
std::string json_number(const std::optional<double> &value);
std::string json_array(const std::vector<std::string> &values);
std::string json_object(std::initializer_list<std::pair<const char *, std::string>> members);

} // namespace afterglow
