// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "core/result.hpp"

#include <CLI/CLI.hpp>

#include <string>

namespace afterglow {

/// afterglow-eval import: turns a published dataset into a recording that everything here replays.
struct ImportArguments {
    std::string dataset;
    std::string recording;
    std::string layout;
    int frames = 0;

    void add_to(CLI::App &command);
};

Status import(const ImportArguments &arguments);

} // namespace afterglow
