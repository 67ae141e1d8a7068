// SPDX-License-Identifier: Apache-2.0
#include "tools/ctl/daemon.hpp"

#include "tools/ctl/bus_value.hpp"

#include <fmt/format.h>

#include <cerrno>
#include <fcntl.h>

namespace afterglow {

Result<Daemon> Daemon::connect(const std::string &bus) {
    Bus connection;
    if (const int error = open_bus(bus.c_str(), connection); error < 0)
        return Error{fmt::format("cannot connect to {}: {}", describe_bus(bus), bus_problem(error)),
                     -error};
    return Daemon(std::move(connection), bus);
}

bool Daemon::is_running(const std::string &bus) {
    Bus connection;
    return open_bus(bus.c_str(), connection) >= 0 &&
           sd_bus_get_name_creds(connection.get(), service_name, 0, nullptr) >= 0;
}

Result<Json> Daemon::properties_on(const std::string &bus) {
    Result<Daemon> daemon = connect(bus);
    if (!daemon)
        return daemon.error();
    return daemon->properties();
}

Result<Json> Daemon::properties() {
    const Result<BusMessage> answer =
        ask(properties_of(depth_interface), "GetAll", "s", depth_interface.name);
    if (!answer)
        return answer.error();
    Result<Json> properties = value_of(answer->get());
    if (properties && !properties->is_object())
        return Error{"the daemon's answer makes no sense", EPROTO};
    return properties;
}

Result<Json> Daemon::get(const Interface &interface, const char *property) {
    const Result<BusMessage> answer =
        ask(properties_of(interface), "Get", "ss", interface.name, property);
    if (!answer)
        return answer.error();
    return value_of(answer->get());
}

Result<Json> Daemon::value_of(sd_bus_message *answer) {
    Json value;
    if (const int error = read_value(answer, value); error < 0)
        return Error{"the daemon's answer makes no sense", -error};
    return value;
}

Result<UniqueFd> Daemon::descriptor_of(sd_bus_message *answer) {
    int lent = -1; // the message's, which closes it
    if (const int error = sd_bus_message_read(answer, "h", &lent); error < 0)
        return Error{"the daemon's answer makes no sense", -error};
    UniqueFd kept(::fcntl(lent, F_DUPFD_CLOEXEC, 0));
    if (!kept)
        return Error{
            fmt::format("the daemon's descriptor cannot be kept: {}", std::strerror(errno)), errno};
    return kept;
}

} // namespace afterglow
