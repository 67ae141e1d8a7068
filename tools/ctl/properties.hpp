// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "tools/ctl/json.hpp"

#include <string>
#include <string_view>

namespace afterglow {

// The daemon's properties, as Daemon::properties() gives them.

/// A name; "unknown" where the daemon has no such property.
std::string text(const Json &properties, const char *name);
/// A number or a boolean; 0 where the daemon has no such property.
double number(const Json &properties, const char *name);

/// Those that are one value each, under their JSON keys.
Json scalars(const Json &properties);

/// The unit of a property: "%", "W"; "" for counts and names.
std::string_view unit(std::string_view property);
/// A value with the unit behind it; "?" for one that is not a string, number or boolean.
std::string with_unit(const Json &value, std::string_view unit);

} // namespace afterglow
