// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "core/base/result.hpp"

#include <nlohmann/json.hpp>
#include <string>
#include <string_view>

namespace afterglow {

using Json = nlohmann::ordered_json;

/// FramesPublished -> frames_published
std::string json_key(std::string_view property);

/// Writes a document to stdout, over several lines; bytes that are not UTF-8 are replaced. Gives 0,
/// as an Action does.
Result<int> print_json(const Json &document);

/// The same on one line, which is written at once, also into a pipe. Errors: stdout cannot be
/// written.
Status print_json_line(const Json &document);

} // namespace afterglow
