// SPDX-License-Identifier: Apache-2.0
#include "tools/ctl/json.hpp"

#include "core/base/standard_output.hpp"

#include <fmt/format.h>

#include <cctype>

namespace afterglow {
namespace {

std::string text_of(const Json &document, int indent) {
    return document.dump(indent, ' ', false, Json::error_handler_t::replace);
}

} // namespace

std::string json_key(std::string_view property) {
    std::string key;
    for (const char letter : property) {
        if (std::isupper(static_cast<unsigned char>(letter)) && !key.empty())
            key += '_';
        key += static_cast<char>(std::tolower(static_cast<unsigned char>(letter)));
    }
    return key;
}

Result<int> print_json(const Json &document) {
    fmt::print("{}\n", text_of(document, 2));
    return 0;
}

Status print_json_line(const Json &document) {
    fmt::print("{}\n", text_of(document, -1));
    return flush_standard_output();
}

} // namespace afterglow
