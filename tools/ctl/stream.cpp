// SPDX-License-Identifier: Apache-2.0
#include "tools/ctl/stream.hpp"

#include "tools/ctl/daemon_proxy.hpp"

#include <fmt/format.h>

#include <cerrno>

namespace afterglow {
namespace {

constexpr int frame_timeout_ms = 10'000;

} // namespace

Result<Stream> Stream::open(const std::string &bus, bool images) {
    afterglow_options options = {};
    options.size = sizeof options;
    options.flags = images ? AFTERGLOW_IMAGES : 0;
    options.bus = bus.c_str();
    afterglow_stream *stream = nullptr;
    if (const int error = afterglow_open(&options, &stream); error < 0)
        return Error{
            fmt::format("no stream from {}: {}", describe_bus(bus), afterglow_strerror(error)),
            -error};
    return Stream(stream);
}

afterglow_info Stream::info() const {
    afterglow_info info = {};
    info.size = sizeof info;
    afterglow_get_info(stream_.get(), &info);
    return info;
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
        if (error < 0 && error != -EAGAIN)
            return Error{afterglow_strerror(error), -error};
    }
}

} // namespace afterglow
