// SPDX-License-Identifier: Apache-2.0
#include "tools/ctl/daemon_proxy.hpp"

#include "core/base/printable.hpp"
#include "ipc/bus.hpp"

#include <fmt/format.h>
#include <systemd/sd-bus.h>

#include <cerrno>
#include <cstring>
#include <memory>
#include <optional>

namespace afterglow {
namespace {

constexpr const char *name = "org.afterglow.Depth1";
constexpr const char *path = "/org/afterglow/Depth1";

struct MessageUnref {
    void operator()(sd_bus_message *message) const { sd_bus_message_unref(message); }
};
using Message = std::unique_ptr<sd_bus_message, MessageUnref>;

/// sd-bus fills it in, and it is freed with this.
struct BusError {
    BusError() = default;
    BusError(const BusError &) = delete;
    BusError &operator=(const BusError &) = delete;
    ~BusError() { sd_bus_error_free(&error); }
    sd_bus_error error = {};
};

Error refusal(const std::string &bus, const sd_bus_error &error, int code) {
    if (sd_bus_error_has_names(&error, SD_BUS_ERROR_SERVICE_UNKNOWN,
                               SD_BUS_ERROR_NAME_HAS_NO_OWNER))
        return Error{fmt::format("no afterglowd runs on {}", describe_bus(bus)), EHOSTUNREACH};
    if (sd_bus_error_has_name(&error, SD_BUS_ERROR_ACCESS_DENIED))
        return Error{"not allowed: this needs root or a member of the group afterglow", EACCES};
    const std::string why = error.message ? printable(error.message) : std::strerror(-code);
    return Error{fmt::format("afterglowd on {} did not do it: {}", describe_bus(bus), why), -code};
}

Result<Bus> connect(const std::string &bus) {
    Bus connection;
    if (const int error = open_bus(bus.c_str(), connection); error < 0)
        return Error{fmt::format("cannot connect to {}: {}", describe_bus(bus), bus_problem(error)),
                     -error};
    return connection;
}

template <class T>
std::optional<T> read_basic(sd_bus_message *message, char type) {
    T value{};
    if (sd_bus_message_read_basic(message, type, &value) < 0)
        return std::nullopt;
    return value;
}

/// The content of the variant that comes next; nothing for a type no property has.
std::optional<Property> read_variant(sd_bus_message *message) {
    const char *content = nullptr;
    if (sd_bus_message_peek_type(message, nullptr, &content) < 0 ||
        sd_bus_message_enter_container(message, 'v', content) < 0)
        return std::nullopt;
    std::optional<Property> property;
    if (std::strcmp(content, "s") == 0) {
        if (const auto text = read_basic<const char *>(message, 's'))
            property = std::string(*text);
    } else if (std::strcmp(content, "t") == 0) {
        property = read_basic<std::uint64_t>(message, 't');
    } else if (std::strcmp(content, "u") == 0) {
        if (const auto number = read_basic<std::uint32_t>(message, 'u'))
            property = std::uint64_t{*number};
    } else if (std::strcmp(content, "d") == 0) {
        property = read_basic<double>(message, 'd');
    } else {
        sd_bus_message_skip(message, content);
    }
    sd_bus_message_exit_container(message);
    return property;
}

} // namespace

Result<Properties> daemon_properties(const std::string &bus) {
    const Result<Bus> connection = connect(bus);
    if (!connection)
        return connection.error();
    BusError problem;
    sd_bus_message *reply = nullptr;
    const int called =
        sd_bus_call_method(connection->get(), name, path, "org.freedesktop.DBus.Properties",
                           "GetAll", &problem.error, &reply, "s", name);
    const Message answer(reply);
    if (called < 0)
        return refusal(bus, problem.error, called);
    Properties properties;
    if (sd_bus_message_enter_container(reply, 'a', "{sv}") < 0)
        return Error{"the daemon's answer makes no sense", EPROTO};
    while (sd_bus_message_enter_container(reply, 'e', "sv") > 0) {
        const auto key = read_basic<const char *>(reply, 's');
        auto value = read_variant(reply);
        if (key && value)
            properties.emplace(*key, std::move(*value));
        sd_bus_message_exit_container(reply);
    }
    return properties;
}

Status set_daemon_mode(const std::string &bus, const std::string &mode) {
    const Result<Bus> connection = connect(bus);
    if (!connection)
        return connection.error();
    BusError problem;
    const int called = sd_bus_set_property(connection->get(), name, path, name, "Mode",
                                           &problem.error, "s", mode.c_str());
    if (called < 0)
        return refusal(bus, problem.error, called);
    return ok();
}

std::string describe_bus(const std::string &bus) {
    if (bus == "system" || bus == "session")
        return fmt::format("the {} bus", bus);
    return fmt::format("the bus at {}", printable(bus));
}

} // namespace afterglow
