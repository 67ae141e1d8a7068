// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <nlohmann/json.hpp>
#include <optional>
#include <string>

/// A number or null. nlohmann-json writes null for numbers that are not finite, too.
template <>
struct nlohmann::adl_serializer<std::optional<double>> {
    static void to_json(json &value, const std::optional<double> &number) {
        value = number ? json(*number) : json();
    }
    static void from_json(const json &value, std::optional<double> &number) {
        number = value.is_number() ? std::optional(value.get<double>()) : std::nullopt;
    }
};

namespace afterglow {

/// The text of a value: one line, or with `indent` spaces for each level. Numbers have as many
/// digits as are needed to read the same number back. Bytes that are not UTF-8, which names of
/// folders may have, become U+FFFD.
inline std::string json_text(const nlohmann::json &value, int indent = -1) {
    return value.dump(indent, ' ', false, nlohmann::json::error_handler_t::replace);
}

} // namespace afterglow
