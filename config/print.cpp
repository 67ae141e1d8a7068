// SPDX-License-Identifier: Apache-2.0
#include "config/parameter_table.hpp"
#include "config/sensor_profiles.hpp"

#include <fmt/format.h>

#include <sstream>

namespace afterglow {
namespace {

/// `text` as lines of a comment, 100 columns wide.
std::string comment(std::string_view text) {
    constexpr std::size_t columns = 100;
    std::string out, line = "#";
    std::istringstream words{std::string(text)};
    for (std::string word; words >> word; line += ' ' + word)
        if (line.size() + 1 + word.size() > columns) {
            out += line + '\n';
            line = "#";
        }
    return out + line + '\n';
}

} // namespace

std::string to_toml(Config config) {
    Config standard;
    if (const SensorProfile *profile = find_sensor_profile(config.sensor_profile))
        profile->apply(standard.estimator.keyframe.surface);
    const ParameterTable table = ParameterTable::of(config);
    const ParameterTable defaults = ParameterTable::of(standard);
    std::string out =
        comment("Configuration of afterglowd: every key, what it is and when to change it, its "
                "value, and what is allowed. The three drivers are required, all else may be left "
                "out. A key that is misspelt or out of range stops the daemon with the line it "
                "stands on.");
    for (const ParameterTable::Section &section : table.sections()) {
        out += fmt::format("\n{}[{}]\n", comment(section.about), section.name);
        for (const Parameter &row : table.rows(section)) {
            const std::string value = toml_value(row), usual = toml_value(*defaults.find(row.key));
            // Written out, it would override any other profile that somebody chooses here,
            const bool is_profiles =
                section.name == "sensor" && row.key != "sensor.profile" && value == usual;
            // or be refused beside the calibration file.
            const bool is_files =
                !config.calibration.file.empty() && is_of_calibration_file(row.key);
            out += fmt::format("{}{}{} = {} # {}{}\n", comment(row.help),
                               is_profiles || is_files ? "# " : "",
                               row.key.substr(section.name.size() + 1), value, describe(row),
                               value == usual ? "" : fmt::format("; default {}", usual));
        }
    }
    return out;
}

std::string reference_page() {
    Config config;
    const ParameterTable table = ParameterTable::of(config);
    std::string out =
        "# Configuration\n"
        "Every key of `afterglowd`'s configuration file. `afterglowd --print-config` prints them "
        "as such a file, with the\ndefaults or the values of the file given by `--config`; "
        "`afterglowd --check` checks one.\n`afterglow-eval` takes the keys that `afterglow-eval "
        "parameters` lists as `--set key=value`.\n\n"
        "This page is printed by `afterglowd --print-reference` from the table in `config/`.\n";
    for (const ParameterTable::Section &section : table.sections()) {
        out += fmt::format("\n## [{}]\n{}\n\n| key | default | allowed | meaning |\n"
                           "|---|---|---|---|\n",
                           section.name, section.about);
        for (const Parameter &row : table.rows(section))
            out += fmt::format("| `{}` | `{}` | {} | {} |\n", row.key, toml_value(row),
                               describe(row), row.help);
    }
    return out;
}

} // namespace afterglow
