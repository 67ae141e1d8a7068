// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "core/base/result.hpp"

#include <string>
#include <vector>

namespace afterglow::bench {

/// A page that shows how times and instruction counts changed from file to file: what `./dev bench`
/// and `./dev bench arm` wrote with --json, the oldest first. An error names the file that is
/// neither, or that lacks what its times are compared with.
Result<std::string> history_page(const std::vector<std::string> &files);

} // namespace afterglow::bench
