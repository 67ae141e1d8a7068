// SPDX-License-Identifier: Apache-2.0
#include "ipc/reader/open_call.hpp"

#include "ipc/bus/bus.hpp"
#include "ipc/bus/errors.hpp"
#include "ipc/bus/service_names.hpp"

#include <algorithm>
#include <cerrno>
#include <fcntl.h>
#include <limits>
#include <string_view>
#include <utility>

namespace afterglow {
namespace {

/// Of a D-Bus call; Link bounds it.
constexpr std::uint64_t no_deadline = std::numeric_limits<std::uint64_t>::max();

/// The errors that afterglow_open() documents; the rest is as libsystemd maps it, but for those
/// that have a meaning of their own here and are nobody else's to say.
int to_errno(const sd_bus_error &error) {
    const std::string_view name = error.name;
    if (sd_bus_error_has_names(&error, SD_BUS_ERROR_SERVICE_UNKNOWN, SD_BUS_ERROR_NAME_HAS_NO_OWNER,
                               SD_BUS_ERROR_UNKNOWN_OBJECT, SD_BUS_ERROR_UNKNOWN_METHOD) ||
        name.starts_with("org.freedesktop.DBus.Error.Spawn.") ||
        name.starts_with("org.freedesktop.systemd1."))
        return -EHOSTUNREACH;
    if (name == SD_BUS_ERROR_LIMITS_EXCEEDED)
        return -ENOBUFS;
    if (name == error_busy)
        return -EBUSY;
    switch (const int code = sd_bus_error_get_errno(&error); code) {
    case 0:
    case EAGAIN:
    case ECONNRESET:
    case EINPROGRESS:
    case EINTR:
    case EPIPE:
    case ESTALE:
        return -EPROTO;
    default:
        return -code;
    }
}

/// Only those that are wanted: an older daemon refuses options that it does not know.
int append(sd_bus_message *call, const StreamOptions &options) {
    int error = sd_bus_message_open_container(call, 'a', "{sv}");
    for (const auto &[name, wanted] :
         {std::pair("images", options.images), std::pair("confidence", options.confidence)})
        if (error >= 0 && wanted)
            error = sd_bus_message_append(call, "{sv}", name, "b", 1);
    if (const auto ms = static_cast<std::uint32_t>(options.interval.count()); error >= 0 && ms > 0)
        error = sd_bus_message_append(call, "{sv}", "interval_ms", "u", ms);
    return error < 0 ? error : sd_bus_message_close_container(call);
}

} // namespace

int OpenCall::start(const char *bus, const StreamOptions &options, bool start_daemon) {
    Bus connection;
    if (const int error = open_bus(bus, connection); error < 0)
        return error;
    bus_ = std::move(connection);
    result_ = -EINPROGRESS;
    sd_bus_message *made = nullptr;
    int error = sd_bus_message_new_method_call(bus_.get(), &made, service_name, service_path,
                                               service_interface, "OpenStream");
    const BusMessage call(made);
    if (error >= 0)
        error = sd_bus_message_set_auto_start(made, start_daemon ? 1 : 0);
    if (error >= 0)
        error = append(made, options);
    if (error >= 0)
        error = sd_bus_call_async(bus_.get(), nullptr, made, on_answer, this, no_deadline);
    return std::min(error, 0);
}

int OpenCall::on_answer(sd_bus_message *answer, void *call, sd_bus_error * /*error*/) {
    OpenCall &self = *static_cast<OpenCall *>(call);
    int lent = -1;
    if (sd_bus_message_is_method_error(answer, nullptr) > 0) {
        self.result_ = to_errno(*sd_bus_message_get_error(answer));
    } else if (sd_bus_message_read(answer, "h", &lent) < 0) {
        self.result_ = -EPROTO;
    } else {
        // A message lends its descriptors; this one outlives it.
        self.socket_ = UniqueFd(::fcntl(lent, F_DUPFD_CLOEXEC, 3));
        self.result_ = self.socket_ ? 0 : -errno;
    }
    return 0;
}

int OpenCall::process(UniqueFd &socket) {
    int done = 1;
    while (result_ == -EINPROGRESS && done > 0)
        done = sd_bus_process(bus_.get(), nullptr);
    if (result_ == -EINPROGRESS && done < 0) // the bus has gone, or never took us
        result_ = done == -EACCES || done == -EPERM ? -EACCES : -ECONNREFUSED;
    if (result_ == 0)
        socket = std::move(socket_);
    return result_;
}

void OpenCall::cancel() {
    bus_.reset();
}

std::uint64_t OpenCall::deadline_us() const {
    std::uint64_t deadline = 0;
    return sd_bus_get_timeout(bus_.get(), &deadline) > 0 ? deadline : no_deadline;
}

} // namespace afterglow
