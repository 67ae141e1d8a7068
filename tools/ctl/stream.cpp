// SPDX-License-Identifier: Apache-2.0
#include "tools/ctl/stream.hpp"

#include "tools/ctl/daemon.hpp"

#include <fmt/format.h>

#include <cerrno>

namespace afterglow {
namespace {

constexpr int frame_timeout_ms = 10'000;

} // namespace

// Not afterglow_open(): it has an errno for a refusal, the D-Bus error says which right is missing.
Result<Stream> Stream::open(const std::string &bus, Planes planes) {
    Result<Daemon> daemon = Daemon::connect(bus);
    if (!daemon)
        return daemon.error();
    Result<UniqueFd> socket = daemon->open("OpenStream", "a{sv}", 1, "images", "b",
                                           static_cast<int>(planes == Planes::images));
    if (!socket)
        return socket.error();
    afterglow_stream *stream = nullptr;
    if (const int error = afterglow_open_fd(socket->release(), &stream); error < 0)
        return Error{
            fmt::format("no stream from {}: {}", describe_bus(bus), afterglow_strerror(error)),
            -error};
    return Stream(stream);
}

Stream::Size Stream::size(afterglow_plane_kind plane) const {
    afterglow_plane_info info = {};
    info.size = sizeof info;
    if (afterglow_get_plane_info(stream_.get(), plane, &info) < 0)
        return {0, 0};
    return {static_cast<int>(info.width), static_cast<int>(info.height)};
}

Result<afterglow_frame> Stream::next(std::span<const afterglow_buffer> buffers) {
    while (true) {
        afterglow_frame frame = {};
        frame.size = sizeof frame;
        int error = afterglow_wait(stream_.get(), frame_timeout_ms);
        if (error == 0)
            error = afterglow_read_latest(stream_.get(), &frame, buffers.data(), buffers.size());
        if (error == 0)
            return frame;
        if (error == -ETIMEDOUT)
            return Error{"no frame came for 10 seconds; see `afterglowctl status`", ETIMEDOUT};
        if (error != -EAGAIN)
            return Error{afterglow_strerror(error), -error};
    }
}

} // namespace afterglow
