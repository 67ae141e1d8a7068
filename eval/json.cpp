// SPDX-License-Identifier: Apache-2.0
#include "eval/json.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <cmath>

namespace afterglow {

std::string json_string(const std::string &text) {
    std::string out = "\"";
    for (const char c : text) {
        if (c == '"' || c == '\\')
            out += fmt::format("\\{}", c);
        else if (static_cast<unsigned char>(c) < 0x20)
            out += fmt::format("\\u{:04x}", static_cast<unsigned>(c));
        else
            out += c;
    }
    return out + '"';
}

std::string json_number(const std::optional<double> &value) {
    return value && std::isfinite(*value) ? fmt::format("{:.4f}", *value) : "null";
}

std::string json_array(const std::vector<std::string> &values) {
    return fmt::format("[{}]", fmt::join(values, ",\n  "));
}

std::string json_object(std::initializer_list<std::pair<const char *, std::string>> members) {
    std::string out;
    for (const auto &[key, value] : members)
        out += fmt::format("{}\"{}\": {}", out.empty() ? "" : ", ", key, value);
    return "{" + out + "}";
}

} // namespace afterglow
