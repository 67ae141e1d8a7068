// SPDX-License-Identifier: Apache-2.0
#include "ipc/bus/policy.hpp"

#include "ipc/bus/errors.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cassert>
#include <cerrno>
#include <cstdint>
#include <utility>
#include <variant>

namespace afterglow {
namespace {

constexpr PolicyProperty properties[] = {
    {"Mode", "s", "gate.mode"},
    {"IntervalFrames", "u", "gate.interval_frames"},
    {"TargetError", "d", "gate.target_mre"},
    {"MeasurementPrice", "d", "gate.measurement_price"},
    {"CoverageFloor", "d", "gate.coverage_floor"},
    {"ShortestInterval", "u", "gate.shortest_interval_frames"},
    {"LongestInterval", "u", "gate.longest_interval_frames"},
    {"DutyCycleBudget", "d", "gate.duty_cycle_budget"},
    {"BudgetBurst", "d", "gate.budget_burst"},
    {"TofPower", "d", "power.tof_w"},
    {"IdlePower", "d", "power.idle_w"},
    {"CorePower", "d", "power.core_w"},
};

bool is_number(const PolicyProperty &property) {
    return *property.type != 's';
}

/// Appends a variable as the D-Bus type that goes with its own.
struct Appended {
    const Parameter &parameter;
    sd_bus_message *reply;

    int operator()(const double *number) const {
        return sd_bus_message_append_basic(reply, 'd', number);
    }
    int operator()(const int *number) const {
        const auto value = static_cast<std::uint32_t>(*number);
        return sd_bus_message_append_basic(reply, 'u', &value);
    }
    int operator()(EnumField name) const {
        return sd_bus_message_append_basic(
            reply, 's', std::string(parameter.allowed.choices[*name.index]).c_str());
    }
    template <class Other>
    int operator()(const Other * /*field*/) const {
        return -EINVAL; // no policy property is of such a type
    }
};

/// The value of a message whose type is the property's.
int read_value(sd_bus_message *message, char type, Value &value) {
    std::uint32_t whole = 0;
    double number = 0;
    const char *text = nullptr;
    int result = 0;
    switch (type) {
    case 'u':
        result = sd_bus_message_read_basic(message, type, &whole);
        value = static_cast<std::int64_t>(whole);
        break;
    case 'd':
        result = sd_bus_message_read_basic(message, type, &number);
        value = number;
        break;
    default:
        result = sd_bus_message_read_basic(message, 's', &text);
        value = std::string(text == nullptr ? "" : text);
    }
    return result;
}

const PolicyProperty &property_named(std::string_view name) {
    const auto property = std::find_if(std::begin(properties), std::end(properties),
                                       [&](const auto &other) { return other.name == name; });
    assert(property != std::end(properties));
    return *property;
}

} // namespace

std::span<const PolicyProperty> policy_properties() {
    return properties;
}

Policy::Policy(const Config &config) : config_(config) {}

void Policy::replace(const Config &config) {
    config_.gate = config.gate;
    config_.power = config.power;
}

const Parameter &Policy::parameter(const PolicyProperty &property) const {
    return *table_.find(property.key);
}

int Policy::append(std::string_view name, sd_bus_message *reply) const {
    const Parameter &row = parameter(property_named(name));
    return std::visit(Appended{row, reply}, row.field);
}

int Policy::set(std::string_view name, sd_bus_message *value, sd_bus_error *error) {
    const PolicyProperty &property = property_named(name);
    Value wanted;
    if (const int read = read_value(value, *property.type, wanted); read < 0)
        return read;
    const auto [gate, power] = std::pair(config_.gate, config_.power);
    Status assigned = assign(parameter(property), wanted);
    if (assigned)
        for (const auto &[key, other, sentence] : table_.conflicts())
            assigned = Error{sentence, EINVAL};
    if (assigned)
        return config_.gate == gate && config_.power == power ? 0 : 1;
    config_.gate = gate;
    config_.power = power;
    return sd_bus_error_setf(error,
                             is_number(property) ? error_out_of_range : SD_BUS_ERROR_INVALID_ARGS,
                             "%s: %s", property.name, assigned.error().message.c_str());
}

std::pair<double, double> Policy::range(std::string_view name) const {
    const Allowed &allowed = parameter(property_named(name)).allowed;
    return {allowed.minimum, allowed.maximum};
}

int Policy::append_ranges(sd_bus_message *reply) const {
    if (const int error = sd_bus_message_open_container(reply, 'a', "{s(dd)}"); error < 0)
        return error;
    for (const PolicyProperty &property : properties) {
        if (!is_number(property))
            continue;
        const auto [least, most] = range(property.name);
        if (const int error = sd_bus_message_append(reply, "{s(dd)}", property.name, least, most);
            error < 0)
            return error;
    }
    return sd_bus_message_close_container(reply);
}

std::string Policy::toml() const {
    std::string text = "# The policy that was saved over D-Bus (SavePolicy). It overrides the "
                       "configuration file.\n";
    for (const PolicyProperty &property : properties)
        text += fmt::format("{} = {}\n", property.key, toml_value(parameter(property)));
    return text;
}

} // namespace afterglow
