// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <systemd/sd-bus.h>

#include <cerrno>
#include <cstring>
#include <memory>

namespace afterglow {

struct BusCloser {
    /// Waits for nobody: what the bus has not taken yet is lost.
    void operator()(sd_bus *bus) const { sd_bus_close_unref(bus); }
};
using Bus = std::unique_ptr<sd_bus, BusCloser>;

struct BusMessageUnref {
    void operator()(sd_bus_message *message) const { sd_bus_message_unref(message); }
};
using BusMessage = std::unique_ptr<sd_bus_message, BusMessageUnref>;

struct BusSlotUnref {
    void operator()(sd_bus_slot *slot) const { sd_bus_slot_unref(slot); }
};
/// A registration, or a call in flight: ends with the object.
using BusSlot = std::unique_ptr<sd_bus_slot, BusSlotUnref>;

/// Why a bus could not be connected to, in words; `error` is the negative errno of open_bus().
inline const char *bus_problem(int error) {
    switch (error) {
    case -ENOMEDIUM:
        return "this user has no session bus ($DBUS_SESSION_BUS_ADDRESS and $XDG_RUNTIME_DIR are "
               "not set)";
    case -ENOENT:
        return "its socket does not exist; no bus runs there";
    case -ECONNREFUSED:
        return "nothing listens on its socket";
    default:
        return std::strerror(-error);
    }
}

/// Connects to the bus called `where`: "system", "session" or a D-Bus address. Returns 0 or a
/// negative errno.
inline int open_bus(const char *where, Bus &bus) {
    sd_bus *opened = nullptr;
    const bool system = std::strcmp(where, "system") == 0;
    if (system || std::strcmp(where, "session") == 0) {
        const int error = system ? sd_bus_open_system(&opened) : sd_bus_open_user(&opened);
        bus.reset(opened);
        return error;
    }
    if (const int error = sd_bus_new(&opened); error < 0)
        return error;
    bus.reset(opened);
    if (const int error = sd_bus_set_address(opened, where); error < 0)
        return error;
    if (const int error = sd_bus_set_bus_client(opened, 1); error < 0)
        return error;
    return sd_bus_start(opened);
}

} // namespace afterglow
