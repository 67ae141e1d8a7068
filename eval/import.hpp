// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "core/base/result.hpp"

#include <CLI/CLI.hpp>

#include <cstddef>
#include <functional>
#include <set>
#include <string>

namespace afterglow {

/// afterglow-eval import: turns a published dataset into a recording that everything here replays.
struct ImportArguments {
    std::string dataset;
    std::string recording;
    std::string layout;
    int frames = 0;
    std::string alteration;

    void add_to(CLI::App &command);
};

Status import(const ImportArguments &arguments);

/// For ImportOptions::progress: shows how far an import is until the last copy of it is gone.
std::function<bool(std::size_t done, std::size_t of)> import_progress();

/// The values of `--layout`.
std::set<std::string> layout_names();

} // namespace afterglow
