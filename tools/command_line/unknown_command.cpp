// SPDX-License-Identifier: Apache-2.0
#include "tools/command_line/unknown_command.hpp"

#include "config/parameter.hpp"
#include "core/base/printable.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <string_view>
#include <vector>

namespace afterglow {

const CLI::App &innermost(const CLI::App &app) {
    const std::vector<CLI::App *> named = app.get_subcommands();
    return named.empty() ? app : innermost(*named.back());
}

std::optional<std::string> unknown_command(const CLI::App &app) {
    if (innermost(app).get_require_subcommand_min() == 0)
        return std::nullopt;
    const std::vector<std::string> words = app.remaining(true);
    const auto name = std::find_if(words.begin(), words.end(),
                                   [](const std::string &word) { return !word.starts_with('-'); });
    return name == words.end() ? std::nullopt : std::optional(*name);
}

std::string no_such_command(const CLI::App &app, const std::string &name) {
    std::vector<std::string_view> known;
    for (const CLI::App *command : app.get_subcommands([](const CLI::App *) { return true; }))
        if (!command->get_name().empty()) // or else it is a group of options
            known.push_back(command->get_name());
    const std::string hint = suggestion(name, known);
    return fmt::format("there is no command \"{}\"{}", printable(name),
                       hint.empty() ? "; --help lists them" : hint);
}

} // namespace afterglow
