// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "config/config.hpp"
#include "config/parameter.hpp"

#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

namespace afterglow {

/// The one declaration of all parameters, bound to the variables of a Config, which must outlive
/// it. The check of a configuration file, `--set`, config/afterglowd.toml, `afterglowd
/// --print-config` and docs/configuration.md are made from it. The default of a parameter is what
/// a new Config has.
class ParameterTable {
public:
    /// A table of TOML.
    struct Section {
        std::string_view name;
        std::string_view about;
        std::optional<Method> used_by; ///< as Parameter::used_by, of all its rows
    };
    /// Two values that contradict each other.
    struct Conflict {
        std::string_view key, other;
        std::string sentence; ///< about `key`
    };

    /// Every key of a configuration file, in its order.
    static ParameterTable of(Config &config);
    /// The keys of the estimator and the gate: what `--set` takes.
    static ParameterTable of_estimator(Config &config);

    std::span<const Section> sections() const { return sections_; }
    std::span<const Parameter> rows() const { return rows_; }
    std::span<const Parameter> rows(const Section &section) const;
    /// Null: there is no such key.
    const Parameter *find(std::string_view key) const;
    bool has_section(std::string_view name) const;
    /// "there is no such key", with the nearest one there is.
    std::string unknown(std::string_view name, bool is_section) const;

    /// What breaks Allowed::at_most.
    std::vector<Conflict> conflicts() const;

    void section(std::string_view name, std::string_view about,
                 std::optional<Method> used_by = std::nullopt);
    /// A row of the last section.
    void add(std::string_view key, Field field, Allowed allowed, std::string_view help,
             std::optional<Method> used_by = std::nullopt);

private:
    std::vector<Section> sections_;
    std::vector<Parameter> rows_;
};

// The rows, in the files of these names.
void add_device_parameters(ParameterTable &table, Config &config);
void add_daemon_parameters(ParameterTable &table, Config &config);
void add_estimator_parameters(ParameterTable &table, Config &config);

/// The names estimator_preset() knows.
std::span<const std::string_view> estimator_preset_names();

/// A configuration file that gives `config`, with every key explained.
std::string to_toml(Config config);
/// docs/configuration.md.
std::string reference_page();

} // namespace afterglow
