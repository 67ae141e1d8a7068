// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "core/base/result.hpp"

#include <string>

namespace afterglow {

/// The content of a file. The error's message is `path: cannot be read: why`.
Result<std::string> read_text(const std::string &path);

} // namespace afterglow
