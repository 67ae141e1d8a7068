// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "tools/ctl/daemon.hpp"

#include <optional>
#include <string>

namespace afterglow {

/// Why this user has not got a right; nothing where he has it.
struct Rights {
    std::optional<std::string> no_depth;
    std::optional<std::string> no_images;
    std::optional<std::string> no_control;
};

/// Asks for what is never given: the daemon looks at rights before it looks at arguments. So
/// nothing begins by it, no camera wakes, and groups and polkit have their say.
Rights rights_of_caller(Daemon &daemon);

} // namespace afterglow
