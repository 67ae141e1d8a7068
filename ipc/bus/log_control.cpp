// SPDX-License-Identifier: Apache-2.0
#include "ipc/bus/log_control.hpp"

#include "core/base/log.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <string>
#include <string_view>

namespace afterglow {
namespace {

// In the order of syslog's numbers.
constexpr std::array<std::string_view, 8> level_names{"emerg",   "alert",  "crit", "err",
                                                      "warning", "notice", "info", "debug"};
// In the order of enum LogTarget.
constexpr std::array<std::string_view, 3> target_names{"console", "journal", "null"};

int append_text(sd_bus_message *reply, std::string_view text) {
    return sd_bus_message_append_basic(reply, 's', std::string(text).c_str());
}

/// The index of the name that a message has.
template <std::size_t count>
int read_name(sd_bus_message *value, const std::array<std::string_view, count> &names,
              sd_bus_error *error) {
    const char *name = nullptr;
    if (const int read = sd_bus_message_read(value, "s", &name); read < 0)
        return read;
    const auto found = std::find(names.begin(), names.end(), std::string_view(name));
    if (found == names.end())
        return sd_bus_error_setf(error, SD_BUS_ERROR_INVALID_ARGS, "'%s' is not one of %s.", name,
                                 fmt::format("{}", fmt::join(names, ", ")).c_str());
    return static_cast<int>(found - names.begin());
}

int get_level(sd_bus * /*bus*/, const char * /*path*/, const char * /*interface*/,
              const char * /*property*/, sd_bus_message *reply, void * /*userdata*/,
              sd_bus_error * /*error*/) {
    return append_text(reply, level_names[static_cast<std::size_t>(log_level())]);
}

int set_level(sd_bus * /*bus*/, const char * /*path*/, const char * /*interface*/,
              const char * /*property*/, sd_bus_message *value, void * /*userdata*/,
              sd_bus_error *error) {
    const int level = read_name(value, level_names, error);
    if (level >= 0)
        set_log_level(level);
    return std::min(level, 0);
}

int get_target(sd_bus * /*bus*/, const char * /*path*/, const char * /*interface*/,
               const char * /*property*/, sd_bus_message *reply, void * /*userdata*/,
               sd_bus_error * /*error*/) {
    return append_text(reply, target_names[static_cast<std::size_t>(log_target())]);
}

int set_target(sd_bus * /*bus*/, const char * /*path*/, const char * /*interface*/,
               const char * /*property*/, sd_bus_message *value, void * /*userdata*/,
               sd_bus_error *error) {
    const int target = read_name(value, target_names, error);
    if (target >= 0 && !set_log_target(static_cast<LogTarget>(target)))
        return sd_bus_error_set(error, SD_BUS_ERROR_INVALID_ARGS,
                                "Standard error does not go to the journal.");
    return std::min(target, 0);
}

int get_identifier(sd_bus * /*bus*/, const char * /*path*/, const char * /*interface*/,
                   const char * /*property*/, sd_bus_message *reply, void * /*userdata*/,
                   sd_bus_error * /*error*/) {
    return append_text(reply, ::program_invocation_short_name);
}

const sd_bus_vtable vtable[] = {
    SD_BUS_VTABLE_START(0),
    SD_BUS_WRITABLE_PROPERTY("LogLevel", "s", get_level, set_level, 0, SD_BUS_VTABLE_UNPRIVILEGED),
    SD_BUS_WRITABLE_PROPERTY("LogTarget", "s", get_target, set_target, 0,
                             SD_BUS_VTABLE_UNPRIVILEGED),
    SD_BUS_PROPERTY("SyslogIdentifier", "s", get_identifier, 0, SD_BUS_VTABLE_PROPERTY_CONST),
    SD_BUS_VTABLE_END,
};

} // namespace

int add_log_control(sd_bus *bus) {
    return sd_bus_add_object_vtable(bus, nullptr, log_control_path, log_control_interface, vtable,
                                    nullptr);
}

} // namespace afterglow
