// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "core/base/unique_fd.hpp"
#include "ipc/bus/bus.hpp"
#include "ipc/stream_options.hpp"

#include <systemd/sd-bus.h>

#include <cstdint>
#include <memory>

namespace afterglow {

/// One call of OpenStream of org.afterglow.Depth1, over a connection of its own. No function of it
/// blocks.
class OpenCall {
public:
    OpenCall() = default;
    OpenCall(const OpenCall &) = delete;
    OpenCall &operator=(const OpenCall &) = delete;

    /// Connects to the bus and calls; `start_daemon`: the bus is to start it where it does not run.
    /// Returns 0, or what the bus refused with.
    int start(const char *bus, const StreamOptions &options, bool start_daemon);
    /// Goes on as far as possible. -EINPROGRESS, 0 with the stream's socket in `socket`, or an
    /// error as documented at afterglow_open().
    int process(UniqueFd &socket);
    /// Breaks off what is under way.
    void cancel();

    // What to wait for, while process() says -EINPROGRESS; fd() is negative while there is no call.
    int fd() const { return bus_ ? sd_bus_get_fd(bus_.get()) : -1; }
    int events() const { return sd_bus_get_events(bus_.get()); }
    /// CLOCK_MONOTONIC, microseconds; UINT64_MAX: only for events.
    std::uint64_t deadline_us() const;

private:
    static int on_answer(sd_bus_message *answer, void *call, sd_bus_error *error);

    Bus bus_;
    UniqueFd socket_;
    int result_ = 0;
};

} // namespace afterglow
