// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "config/parameter_table.hpp"

#include <systemd/sd-bus.h>

#include <span>
#include <string>
#include <string_view>
#include <utility>

namespace afterglow {

/// A property of org.afterglow.Depth1 that clients may set, and the key of the configuration that
/// is behind it. Its variable, range and unit are those of the key.
struct PolicyProperty {
    const char *name;
    const char *type; ///< D-Bus signature
    std::string_view key;
};

/// All of them, in the order of org.afterglow.Depth1.xml.
std::span<const PolicyProperty> policy_properties();

/// What the daemon's own policy is: that of the configuration, until clients change it. Main thread
/// only.
class Policy {
public:
    explicit Policy(const Config &config);
    Policy(const Policy &) = delete;
    Policy &operator=(const Policy &) = delete;

    const GatePolicy &gate() const { return config_.gate; }
    const PowerModel &power() const { return config_.power; }
    /// Takes the policy of another configuration.
    void replace(const Config &config);

    // For D-Bus; `name` is that of a property above. They return as functions of sd-bus do.
    int append(std::string_view name, sd_bus_message *reply) const;
    /// Reads the property's new value. 1: it is another one. On failure `error` says what is
    /// allowed and the policy is as before.
    int set(std::string_view name, sd_bus_message *value, sd_bus_error *error);
    /// Minimum and maximum of a property that is a number.
    std::pair<double, double> range(std::string_view name) const;
    /// Appends a{s(dd)}: minimum and maximum of the properties that are numbers.
    int append_ranges(sd_bus_message *reply) const;

    /// All of it, as a file that load_config() takes.
    std::string toml() const;

private:
    const Parameter &parameter(const PolicyProperty &property) const;

    Config config_; ///< only what policy_properties() names is used
    ParameterTable table_ = ParameterTable::of(config_);
};

} // namespace afterglow
