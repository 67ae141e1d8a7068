// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "core/base/result.hpp"

#include <CLI/CLI.hpp>

#include <functional>

namespace afterglow {

/// Does what a command is there for, writing to stdout. Gives the exit status.
using CalibrateAction = std::function<Result<int>()>;

// Each declares its options and gives what it does.
CalibrateAction declare_print_board(CLI::App &app);
CalibrateAction declare_capture(CLI::App &app);
CalibrateAction declare_solve(CLI::App &app);

} // namespace afterglow
