// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "core/base/result.hpp"
#include "core/base/unique_fd.hpp"
#include "ipc/ring/ring_writer.hpp"
#include "ipc/stream_options.hpp"

#include <sys/types.h>

#include <algorithm>
#include <array>
#include <atomic>
#include <chrono>
#include <cstdint>
#include <functional>
#include <memory>
#include <mutex>
#include <span>
#include <thread>
#include <vector>

struct epoll_event;

namespace afterglow {

/// Whose a stream is.
struct StreamClaim {
    uid_t user = 0;
    StreamOptions options;
    std::uint64_t owner = 0; ///< what open() was given
};

/// Processor time that the datagrams of a stream take beyond a fair cost each, in all.
class ExcessCost {
public:
    /// In fair costs. A datagram counts as half of it at most: the kernel counts an interrupt, or
    /// the time in which the host of a virtual machine runs something else, as the sender's time.
    static constexpr int too_much = 50;

    /// Adds a datagram. True when it is too much, which takes at least three.
    bool add(std::chrono::nanoseconds cost, std::chrono::nanoseconds fair) {
        sum_ += std::min(cost - fair, too_much / 2 * fair);
        sum_ = std::max(sum_, std::chrono::nanoseconds(0));
        return sum_ > too_much * fair;
    }

private:
    std::chrono::nanoseconds sum_{0};
};

/// The daemon's ends of the open streams' sockets, and the thread that sends on them.
///
///   estimator thread ──eventfd──▶ notifier thread ──a datagram each──▶ readers
///                                        └────────eventfd────────────▶ main thread
///
/// Each stream is a SOCK_SEQPACKET pair on which only the daemon sends (afterglow_message). What a
/// client does with its end costs the estimator thread nothing, and the notifier no more than this:
/// - it does not read: what finds no room is left out, until it reads again;
/// - it sends: refused by the kernel, our end is shut for reading;
/// - it closes, shuts down or dies: the kernel says so, and the stream ends;
/// - it makes thousands wait for the socket, whose queue each datagram walks: the stream ends as
///   soon as that has cost too much, and its user gets no other for a while.
/// After a stream's end the others get a new memory, within a second, so that a client that has
/// kept the mapping sees nothing more.
class StreamNotifier {
public:
    static constexpr int most_streams = 64;
    static constexpr int most_streams_of_a_user = 16; ///< so that no user can lock out the others
    /// The least time between renewals of the memory that clients cause.
    static constexpr std::chrono::milliseconds renewal_pause{1000};

    /// Processor time that a datagram to a reader may take; 10 us are usual. On a machine on which
    /// one to nobody takes more than a tenth of that, ten times as long as that takes.
    static constexpr std::chrono::microseconds fair_cost{100};
    static constexpr std::chrono::seconds refusal{60};

    /// Starts the thread, which calls `at_start` first, if any: to give itself a priority. `ring`
    /// outlives the notifier. Errors: the errno of a descriptor.
    static Result<std::unique_ptr<StreamNotifier>> create(RingWriter &ring,
                                                          std::function<void()> at_start = {});
    /// Ends all streams.
    ~StreamNotifier();
    StreamNotifier(const StreamNotifier &) = delete;
    StreamNotifier &operator=(const StreamNotifier &) = delete;

    /// A frame was published. Estimator thread; one write to an eventfd.
    void frame_published() const;

    // The main thread's side.

    /// Opens a stream for `user` and returns the client's end. `owner` is for close_if(). Fails
    /// with EDQUOT at a limit above and for a user whose stream was ended as too expensive, or when
    /// the system refuses a descriptor or memory.
    Result<UniqueFd> open(uid_t user, const StreamOptions &options, std::uint64_t owner = 0);
    /// Ends the streams for which `ends` is true, saying `error` (AFTERGLOW_MESSAGE_END), and gives
    /// the rest a new memory at once. Returns how many were ended.
    int close_if(const std::function<bool(const StreamClaim &)> &ends, int error);
    /// Streams open now.
    int count() const { return count_.load(std::memory_order_acquire); }
    /// Whether one of them has images.
    bool takes_images() const;
    /// Readable after frames were announced, and when there is something for update() to do.
    int event_fd() const { return event_.get(); }
    /// Makes event_fd() quiet, and renews the memory when that is due. An error of it is one for
    /// the log; it is tried again.
    Status update();

private:
    using Clock = std::chrono::steady_clock;
    struct Stream {
        UniqueFd socket;
        StreamClaim claim;
        std::uint64_t renewal = 0; ///< of the memory sent last
        ExcessCost excess = {};
    };

    StreamNotifier(RingWriter &ring, UniqueFd epoll, UniqueFd frames, UniqueFd event,
                   std::function<void()> at_start);
    void run();
    /// Handles what came; true when the main thread is to know.
    bool turn(std::span<const epoll_event> events);
    void announce_to_all(std::uint64_t index, bool frame);
    void end_expensive(Stream &stream);
    bool announce(Stream &stream, std::uint64_t index, bool frame);
    Status check_limits(uid_t user) const;
    Result<UniqueFd> connect(Stream &place, const StreamClaim &claim);
    void end(Stream &stream, int error);
    void end_hung_up();
    void pass_on_wishes();
    bool wished_for(bool StreamOptions::*option) const;
    std::chrono::milliseconds shortest_interval() const;
    bool renewal_due() const;
    int wait_ms() const;
    Status renew_if_due();
    Status renew(bool forced);
    void wake_thread() const;

    RingWriter &ring_;
    const UniqueFd epoll_;
    const UniqueFd frames_; ///< written by the estimator thread, and to wake the notifier
    const UniqueFd event_;  ///< written by the notifier for the main thread
    std::atomic<int> count_ = 0;
    std::atomic<bool> stop_ = false;

    mutable std::mutex mutex_; ///< never taken by the estimator thread; guards what follows
    std::array<Stream, most_streams> streams_;       ///< those without a socket are free
    std::chrono::nanoseconds fair_cost_ = fair_cost; ///< on this machine
    bool memory_pending_ = false;                    ///< a stream waits for the newest memory
    bool renewal_wanted_ = false;                    ///< a stream has ended since the last one
    Clock::time_point last_renewal_;
    std::vector<UniqueFd> expensive_; ///< sockets that take long even to close, for update()
    struct Refusal {
        uid_t user = 0;
        Clock::time_point until{};
    };
    std::array<Refusal, most_streams> refusals_; ///< the newest first

    std::uint64_t announced_ = 0; ///< the thread's: frames announced
    std::thread thread_;
};

} // namespace afterglow
