// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "core/base/result.hpp"

#include <systemd/sd-bus.h>

#include <string>

namespace afterglow {

/// "the system bus", "the bus at unix:path=/run/bus".
std::string describe_bus(const std::string &bus);

/// What a D-Bus error of the daemon, or of the bus called `bus`, means to a person, and what to do
/// about it. `code`: the negative errno that libsystemd gave with it.
Error refusal(const std::string &bus, const sd_bus_error &error, int code);

} // namespace afterglow
