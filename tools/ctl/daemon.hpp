// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "core/base/result.hpp"
#include "core/base/unique_fd.hpp"
#include "ipc/bus/bus.hpp"
#include "ipc/bus/log_control.hpp"
#include "ipc/bus/service_names.hpp"
#include "tools/ctl/json.hpp"
#include "tools/ctl/refusal.hpp"

#include <memory>
#include <string>
#include <utility>

namespace afterglow {

/// An interface of the daemon, and the object that has it.
struct Interface {
    const char *object;
    const char *name;
};
inline constexpr Interface depth_interface = {service_path, service_interface};
inline constexpr Interface log_interface = {log_control_path, log_control_interface};

/// The daemon on a bus. Each call waits for its answer. Errors are sentences that say what to do,
/// with the errno that libsystemd has for the D-Bus error.
class Daemon {
public:
    /// `bus`: "system", "session" or an address. Does not ask yet whether a daemon is on it.
    static Result<Daemon> connect(const std::string &bus);
    /// Whether there is a bus with a daemon on it. Has the bus start none.
    static bool is_running(const std::string &bus);
    /// properties() of the daemon on that bus, for those who want nothing else.
    static Result<Json> properties_on(const std::string &bus);

    /// Calls a method of org.afterglow.Depth1 with `arguments` of the D-Bus types `types`. Gives
    /// what it answers; null when that is nothing.
    template <class... Arguments>
    Result<Json> call(const char *method, const char *types, Arguments... arguments) {
        const Result<BusMessage> answer = ask(depth_interface, method, types, arguments...);
        if (!answer)
            return answer.error();
        return value_of(answer->get());
    }
    /// The same for a method that answers with a descriptor.
    template <class... Arguments>
    Result<UniqueFd> open(const char *method, const char *types, Arguments... arguments) {
        const Result<BusMessage> answer = ask(depth_interface, method, types, arguments...);
        if (!answer)
            return answer.error();
        return descriptor_of(answer->get());
    }

    /// All properties of org.afterglow.Depth1, an object.
    Result<Json> properties();
    Result<Json> get(const Interface &interface, const char *property);
    /// `type`: of the property in D-Bus; `value` is of it.
    template <class Value>
    Status set(const Interface &interface, const char *property, const char *type, Value value) {
        const Result<BusMessage> done =
            ask(properties_of(interface), "Set", "ssv", interface.name, property, type, value);
        if (!done)
            return done.error();
        return ok();
    }

private:
    /// sd-bus fills it in, and it is freed with this.
    struct BusError {
        BusError() = default;
        BusError(const BusError &) = delete;
        BusError &operator=(const BusError &) = delete;
        ~BusError() { sd_bus_error_free(&content); }
        sd_bus_error content = {};
    };

    Daemon(Bus connection, std::string bus)
        : connection_(std::move(connection)), bus_(std::move(bus)) {}

    static Interface properties_of(const Interface &interface) {
        return {interface.object, "org.freedesktop.DBus.Properties"};
    }

    template <class... Arguments>
    Result<BusMessage> ask(const Interface &interface, const char *method, const char *types,
                           Arguments... arguments) {
        BusError problem;
        sd_bus_message *reply = nullptr;
        const int called =
            sd_bus_call_method(connection_.get(), service_name, interface.object, interface.name,
                               method, &problem.content, &reply, types, arguments...);
        BusMessage answer(reply);
        if (called < 0)
            return refusal(bus_, problem.content, called);
        return answer;
    }
    static Result<Json> value_of(sd_bus_message *answer);
    static Result<UniqueFd> descriptor_of(sd_bus_message *answer);

    Bus connection_;
    std::string bus_;
};

} // namespace afterglow
