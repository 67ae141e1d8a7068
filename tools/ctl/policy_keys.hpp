// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "tools/ctl/json.hpp"

#include <cstdint>
#include <span>
#include <string>
#include <string_view>
#include <variant>

namespace afterglow {

/// A writable property of org.afterglow.Depth1.
struct PolicyKey {
    const char *name;
    char type;                  ///< in D-Bus: s, u or d
    const char *effective = ""; ///< the property with what rules now, if requests can change it
    const char *wish = "";      ///< what requests call it in ListRequests
};

std::span<const PolicyKey> policy_keys();

/// The key that a person means: TargetError, target-error and target_error are the same. Throws
/// CLI::ValidationError: there is none.
const PolicyKey &policy_key(const std::string &name);

/// A value of the key's type, from a command line. Throws CLI::ValidationError: it is no number.
using PolicyValue = std::variant<std::string, std::uint32_t, double>;
PolicyValue policy_value(const PolicyKey &key, const std::string &text);

/// What is known of a key: value, unit, range; and for what requests can change, what rules now
/// (null: there is no limit) and the requests that ask for it. `requests`: of list_requests().
Json describe_key(const PolicyKey &key, const Json &properties, const Json &requests);

} // namespace afterglow
