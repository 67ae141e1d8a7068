// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "config/config.hpp"

#include <optional>
#include <string>
#include <vector>

namespace afterglow {

/// Where the daemon's configuration is, as its command line says.
struct ConfigurationFiles {
    std::string config;
    std::string policy; ///< what SavePolicy writes; "" for none
    std::string bus;    ///< overrides daemon.bus; "" does not
};

/// Reads them (load_config()).
Result<Config> read_configuration(const ConfigurationFiles &files);

/// The cameras that a daemon started with `running` can take from `read` while it runs: real ones,
/// of the same sizes.
std::optional<RigGeometry> live_geometry(const Config &running, const Config &read);

/// The keys that differ and that the daemon reads only at its start.
std::vector<std::string> restart_needed(Config running, Config read);

} // namespace afterglow
