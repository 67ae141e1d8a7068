// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "core/base/unique_fd.hpp"
#include "ipc/reader/open_call.hpp"
#include "ipc/reader/stream_socket.hpp"

#include <cstdint>

namespace afterglow {

/// The way to the daemon, and back to the next one:
///
///   calling ──socket──▶ open ──end──▶ (ended, or with `reconnect`) waiting ──time──▶ calling
///      └──────────no daemon (with `reconnect`)──────────────────────────▲
///
/// Everything that it waits for is behind one descriptor, the same for its whole life. No function
/// of it blocks.
class Link {
public:
    struct Options {
        const char *bus = nullptr; ///< outlives the link; nullptr: it only has adopt()ed a socket
        StreamOptions stream;
        bool reconnect = false;
        std::uint64_t timeout_us = 0; ///< of one call
    };
    struct Event {
        enum class Kind {
            none,   ///< nothing more has come
            memory, ///< `message` has the descriptors
            lost,   ///< the stream is over, another will be asked for
            ended,  ///< nothing will ever come, because of problem()
        } kind = Kind::none;
        StreamMessage message;
    };

    /// Makes the descriptors: 0 or a negative errno.
    int create(const Options &options);
    /// Begins to ask for a stream.
    void call();
    /// Begins with a stream that somebody else has asked for.
    void adopt(UniqueFd socket);
    /// Ends it for good.
    void end(int error);
    /// Looks at what has come.
    Event next();

    /// Becomes readable when next() may have something.
    int fd() const { return epoll_.get(); }
    bool ended() const { return state_ == State::ended; }
    bool reconnects() const { return options_.reconnect; }
    /// Why there is no stream (any more): negative errno; 0 while one is open or nothing has
    /// failed.
    int problem() const { return problem_; }

private:
    enum class State { waiting, calling, open, ended };

    /// Asks for another stream later, or ends it.
    Event lose(int error);
    /// Closes the socket and breaks off the call.
    void close();
    /// 0 or a negative errno, as watch_call().
    int watch(int fd, std::uint32_t events);
    int watch_call();
    /// `fd()` is readable from then on; CLOCK_MONOTONIC, microseconds, 0: never.
    void set_timer(std::uint64_t due_us);

    Options options_;
    State state_ = State::waiting;
    UniqueFd epoll_;
    UniqueFd timer_;
    OpenCall call_;
    UniqueFd socket_;
    /// Only the first stream has the bus start the daemon: one that was stopped stays so.
    bool was_open_ = false;
    int problem_ = 0;
    std::uint64_t due_us_ = 0;  ///< of the call's end or the next one's beginning
    std::uint64_t lost_us_ = 0; ///< since when there is no stream; 0: there is one, or never was
};

} // namespace afterglow
