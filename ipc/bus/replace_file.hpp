// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "core/base/result.hpp"

#include <string>
#include <string_view>

namespace afterglow {

/// Writes a file so that, whatever happens meanwhile, `path` is the old one or the new one as a
/// whole. It is readable by its owner alone. Errors: the errno of open(), write(), fsync() or
/// rename(), with a sentence.
Status replace_file(const std::string &path, std::string_view text);

} // namespace afterglow
