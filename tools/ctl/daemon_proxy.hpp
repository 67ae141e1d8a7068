// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "core/base/result.hpp"

#include <cstdint>
#include <map>
#include <string>
#include <variant>

namespace afterglow {

/// A property of org.afterglow.Depth1.
using Property = std::variant<std::string, std::uint64_t, double>;
using Properties = std::map<std::string, Property>;

/// All properties of the daemon on the bus called `bus` ("system", "session" or an address).
Result<Properties> daemon_properties(const std::string &bus);

/// Sets the daemon's mode; it refuses what it does not know and whom it does not allow.
Status set_daemon_mode(const std::string &bus, const std::string &mode);

/// "the system bus", "the bus at unix:path=/run/bus".
std::string describe_bus(const std::string &bus);

} // namespace afterglow
