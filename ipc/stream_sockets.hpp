// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "core/base/result.hpp"
#include "ipc/unique_fd.hpp"

#include <sys/types.h>
#include <systemd/sd-event.h>

#include <cstdint>
#include <functional>
#include <list>

namespace afterglow {

/// The daemon's ends of the open streams' sockets. D-Bus thread only.
///
/// Each stream is a SOCK_SEQPACKET pair that only the daemon sends on: a wake-up for each frame,
/// the frame's index as uint64. Nothing that a client does with its end costs more than this:
/// - it does not read: the wake-ups that find no room are left out, until it reads again;
/// - it sends: refused by the kernel, our end is shut for reading;
/// - it closes, shuts down or dies: the kernel says so, and the stream ends.
class StreamSockets {
public:
    static constexpr int most_streams = 64;
    static constexpr int most_streams_of_a_user = 16; ///< so that no user can lock out the others

    /// `changed` is called after each opening and ending with the number of open streams.
    StreamSockets(sd_event *event, std::function<void(int)> changed);
    ~StreamSockets();
    StreamSockets(const StreamSockets &) = delete;

    /// Opens a stream for `user` and returns the client's end. Fails with EDQUOT at a limit above,
    /// or when the system has no descriptor left.
    Result<UniqueFd> open(uid_t user);
    /// Tells all streams of a new frame.
    void wake(std::uint64_t frame_index);
    int count() const { return static_cast<int>(streams_.size()); }

private:
    struct Stream;
    static int on_hang_up(sd_event_source *source, int fd, std::uint32_t events, void *stream);

    sd_event *event_;
    std::function<void(int)> changed_;
    std::list<Stream> streams_;
};

} // namespace afterglow
