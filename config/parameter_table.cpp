// SPDX-License-Identifier: Apache-2.0
#include "config/parameter_table.hpp"

#include <fmt/format.h>

#include <algorithm>

namespace afterglow {
namespace {

constexpr std::string_view preset_names[] = {"default", "paper"};

std::string_view section_of(const Parameter &row) {
    return row.key.substr(0, row.key.find('.'));
}

double number_of(const Field &field) {
    return std::visit(
        [](auto variable) -> double {
            if constexpr (std::is_arithmetic_v<std::remove_pointer_t<decltype(variable)>>)
                return static_cast<double>(*variable);
            return 0;
        },
        field);
}

} // namespace

std::span<const std::string_view> estimator_preset_names() {
    return preset_names;
}

ParameterTable ParameterTable::of(Config &config) {
    ParameterTable table;
    add_device_parameters(table, config);
    table.section("estimator", "How depth is estimated (docs/estimation.md).");
    table.add("estimator.preset", &config.preset, {.choices = preset_names},
              "default is the pipeline of this project, paper that of Noraky & Sze 2019; choose "
              "paper to compare. Keys of the other preset change nothing.");
    add_estimator_parameters(table, config);
    add_daemon_parameters(table, config);
    return table;
}

ParameterTable ParameterTable::of_estimator(Config &config) {
    ParameterTable table;
    add_estimator_parameters(table, config);
    // A name for several values: these can be given one by one.
    std::erase_if(table.rows_, [](const Parameter &row) { return row.key == "sensor.profile"; });
    return table;
}

std::span<const Parameter> ParameterTable::rows(const Section &section) const {
    const auto is_of = [&](const Parameter &row) { return section_of(row) == section.name; };
    const auto first = std::find_if(rows_.begin(), rows_.end(), is_of);
    return {first, std::find_if_not(first, rows_.end(), is_of)};
}

const Parameter *ParameterTable::find(std::string_view key) const {
    const auto row = std::find_if(rows_.begin(), rows_.end(),
                                  [&](const Parameter &other) { return other.key == key; });
    return row == rows_.end() ? nullptr : &*row;
}

bool ParameterTable::has_section(std::string_view name) const {
    return std::any_of(sections_.begin(), sections_.end(),
                       [&](const Section &section) { return section.name == name; });
}

std::string ParameterTable::unknown(std::string_view name, bool is_section) const {
    std::vector<std::string_view> names;
    for (const Parameter &row : rows_)
        names.push_back(is_section ? section_of(row) : row.key);
    return fmt::format("there is no such {}{}", is_section ? "table" : "key",
                       suggestion(name, names));
}

std::vector<ParameterTable::Conflict> ParameterTable::conflicts() const {
    std::vector<Conflict> found;
    for (const Parameter &row : rows_) {
        const Parameter *limit = find(row.allowed.at_most);
        if (limit && number_of(row.field) > number_of(limit->field))
            found.push_back({row.key, limit->key,
                             fmt::format("{} is not allowed ({}, which is {})", toml_value(row),
                                         describe(row), toml_value(*limit))});
    }
    return found;
}

void ParameterTable::section(std::string_view name, std::string_view about,
                             std::optional<Method> used_by) {
    sections_.push_back({name, about, used_by});
}

void ParameterTable::add(std::string_view key, Field field, Allowed allowed, std::string_view help,
                         std::optional<Method> used_by) {
    rows_.push_back({key, field, allowed, help, used_by ? used_by : sections_.back().used_by});
}

} // namespace afterglow
