// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <systemd/sd-bus.h>

namespace afterglow {

inline constexpr const char *log_control_path = "/org/freedesktop/LogControl1";
inline constexpr const char *log_control_interface = "org.freedesktop.LogControl1";

/// Offers org.freedesktop.LogControl1: level and target of this process's log. The object lasts as
/// long as the connection. Returns 0 or a negative errno.
int add_log_control(sd_bus *bus);

} // namespace afterglow
