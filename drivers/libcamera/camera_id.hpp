// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "core/base/result.hpp"

#include <span>
#include <string>

namespace afterglow::libcam {

/// The id that is `wanted`, or else the only one that has it within. Errors (ENODEV): none does, or
/// several do; they name the cameras there are.
Result<std::string> choose_id(std::span<const std::string> ids, const std::string &wanted);

} // namespace afterglow::libcam
