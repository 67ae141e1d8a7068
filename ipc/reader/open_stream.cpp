// SPDX-License-Identifier: Apache-2.0
#include "ipc/reader/open_stream.hpp"

#include "ipc/bus.hpp"

#include <cerrno>
#include <fcntl.h>
#include <memory>

namespace afterglow {
namespace {

struct MessageUnref {
    void operator()(sd_bus_message *message) const { sd_bus_message_unref(message); }
};
using Message = std::unique_ptr<sd_bus_message, MessageUnref>;

/// The errors of the bus that afterglow_open() documents; the rest is as libsystemd maps it.
int to_errno(const sd_bus_error &error, int code) {
    if (sd_bus_error_has_names(&error, SD_BUS_ERROR_SERVICE_UNKNOWN, SD_BUS_ERROR_NAME_HAS_NO_OWNER,
                               SD_BUS_ERROR_UNKNOWN_OBJECT, SD_BUS_ERROR_UNKNOWN_METHOD))
        return -EHOSTUNREACH;
    if (sd_bus_error_has_name(&error, SD_BUS_ERROR_LIMITS_EXCEEDED))
        return -ENOBUFS;
    return code;
}

/// A message lends its descriptors; this one outlives it.
int keep(int fd, UniqueFd &kept) {
    kept = UniqueFd(::fcntl(fd, F_DUPFD_CLOEXEC, 3));
    return kept ? 0 : -errno;
}

} // namespace

int open_stream(const char *bus_name, UniqueFd &memfd, UniqueFd &socket) {
    Bus bus;
    if (const int error = open_bus(bus_name != nullptr ? bus_name : "system", bus); error < 0)
        return error;
    sd_bus_error problem{};
    sd_bus_message *answered = nullptr;
    const int called =
        sd_bus_call_method(bus.get(), "org.afterglow.Depth1", "/org/afterglow/Depth1",
                           "org.afterglow.Depth1", "OpenStream", &problem, &answered, "a{sv}", 0);
    const Message answer(answered);
    const int refused = called < 0 ? to_errno(problem, called) : 0;
    sd_bus_error_free(&problem);
    if (refused < 0)
        return refused;
    int lent_memfd = -1;
    int lent_socket = -1;
    if (sd_bus_message_read(answered, "hh", &lent_memfd, &lent_socket) < 0)
        return -EPROTO;
    if (const int error = keep(lent_memfd, memfd); error < 0)
        return error;
    return keep(lent_socket, socket);
}

} // namespace afterglow
