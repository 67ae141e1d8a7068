// SPDX-License-Identifier: Apache-2.0
#include "ipc/ring/stream_notifier.hpp"

#include "core/base/clock.hpp"
#include "ipc/ring/stream_message.hpp"

#include <fmt/format.h>
#include <sys/epoll.h>
#include <sys/eventfd.h>
#include <sys/socket.h>

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <ctime>
#include <optional>
#include <poll.h>
#include <utility>

namespace afterglow {
namespace {

using std::chrono::milliseconds;
using std::chrono::nanoseconds;

/// How often a memory that found no room is tried again when no frame comes.
constexpr milliseconds retry_pause{100};

Error failed(int code) {
    return Error{fmt::format("Cannot open a stream: {}.", std::strerror(code)), code};
}

/// Our end of a pair: shut for reading, with as little room as the kernel gives. A notification
/// that waits for long says nothing.
Status prepare(const UniqueFd &socket) {
    const int least = 1;
    if (::setsockopt(socket.get(), SOL_SOCKET, SO_SNDBUF, &least, sizeof least) < 0 ||
        ::shutdown(socket.get(), SHUT_RD) < 0)
        return failed(errno);
    return ok();
}

/// Of this thread.
nanoseconds processor_time() {
    return nanoseconds(clock_ns(CLOCK_THREAD_CPUTIME_ID));
}

/// Processor time of one that nobody waits for: the median of a few. 0 where there is no socket.
nanoseconds cost_of_a_datagram() {
    int ends[2];
    if (::socketpair(AF_UNIX, SOCK_SEQPACKET | SOCK_CLOEXEC | SOCK_NONBLOCK, 0, ends) != 0)
        return nanoseconds(0);
    const UniqueFd ours(ends[0]), theirs(ends[1]);
    std::array<nanoseconds, 15> costs;
    for (nanoseconds &cost : costs) {
        const nanoseconds before = processor_time();
        send_frame(ours.get(), 0);
        cost = processor_time() - before;
        afterglow_message read;
        static_cast<void>(::recv(theirs.get(), &read, sizeof read, 0));
    }
    std::ranges::nth_element(costs, costs.begin() + costs.size() / 2);
    return costs[costs.size() / 2];
}

bool hung_up(const UniqueFd &socket) {
    pollfd poll = {socket.get(), 0, 0};
    return ::poll(&poll, 1, 0) == 1 && (poll.revents & POLLHUP) != 0;
}

} // namespace

Result<std::unique_ptr<StreamNotifier>> StreamNotifier::create(RingWriter &ring,
                                                               std::function<void()> at_start) {
    UniqueFd epoll(::epoll_create1(EPOLL_CLOEXEC));
    UniqueFd frames(::eventfd(0, EFD_NONBLOCK | EFD_CLOEXEC));
    UniqueFd event(::eventfd(0, EFD_NONBLOCK | EFD_CLOEXEC));
    // Edge-triggered: each write wakes, and nobody has to read the counter.
    epoll_event wake = {EPOLLIN | EPOLLET, {.ptr = nullptr}};
    if (!epoll || !frames || !event ||
        ::epoll_ctl(epoll.get(), EPOLL_CTL_ADD, frames.get(), &wake) < 0)
        return Error{fmt::format("cannot announce frames: {}", std::strerror(errno)), errno};
    return std::unique_ptr<StreamNotifier>(new StreamNotifier(
        ring, std::move(epoll), std::move(frames), std::move(event), std::move(at_start)));
}

StreamNotifier::StreamNotifier(RingWriter &ring, UniqueFd epoll, UniqueFd frames, UniqueFd event,
                               std::function<void()> at_start)
    : ring_(ring), epoll_(std::move(epoll)), frames_(std::move(frames)), event_(std::move(event)),
      announced_(ring.head()) {
    thread_ = std::thread([this, prepare = std::move(at_start)] {
        if (prepare)
            prepare();
        {
            const std::lock_guard lock(mutex_);
            fair_cost_ = std::max<nanoseconds>(fair_cost, 10 * cost_of_a_datagram());
        }
        run();
    });
}

StreamNotifier::~StreamNotifier() {
    stop_ = true;
    wake_thread();
    thread_.join();
    for (Stream &stream : streams_)
        if (stream.socket)
            end(stream, EPIPE);
}

void StreamNotifier::frame_published() const {
    wake_thread();
}

void StreamNotifier::wake_thread() const {
    ::eventfd_write(frames_.get(), 1);
}

Result<UniqueFd> StreamNotifier::open(uid_t user, const StreamOptions &options,
                                      std::uint64_t owner) {
    // Who comes after a stream that has ended gets a memory which that one has never seen. If it is
    // refused, update() tries again and says so.
    static_cast<void>(renew_if_due());

    const std::lock_guard lock(mutex_);
    Status within = check_limits(user);
    if (!within) {
        end_hung_up();
        within = check_limits(user);
    }
    if (!within)
        return within.error();
    const auto place = std::find_if(streams_.begin(), streams_.end(),
                                    [](const Stream &stream) { return !stream.socket; });
    Result<UniqueFd> client = connect(*place, {user, options, owner});
    if (client)
        ++count_;
    pass_on_wishes();
    return client;
}

Status StreamNotifier::check_limits(uid_t user) const {
    if (count() == most_streams)
        return Error{fmt::format("All {} streams are open.", most_streams), EDQUOT};
    const auto of_user = std::count_if(streams_.begin(), streams_.end(), [&](const Stream &stream) {
        return stream.socket && stream.claim.user == user;
    });
    if (std::any_of(refusals_.begin(), refusals_.end(), [&](const Refusal &one) {
            return one.user == user && one.until > Clock::now();
        }))
        return Error{
            fmt::format("A stream of user {} was too expensive: try again in a minute.", user),
            EDQUOT};
    if (of_user >= most_streams_of_a_user)
        return Error{fmt::format("User {} has {} streams open, the most that one user may have.",
                                 user, of_user),
                     EDQUOT};
    return ok();
}

Result<UniqueFd> StreamNotifier::connect(Stream &place, const StreamClaim &claim) {
    int ends[2];
    if (::socketpair(AF_UNIX, SOCK_SEQPACKET | SOCK_CLOEXEC | SOCK_NONBLOCK, 0, ends) < 0)
        return failed(errno);
    UniqueFd ours(ends[0]);
    UniqueFd theirs(ends[1]);
    if (Status prepared = prepare(ours); !prepared)
        return prepared.error();
    // Before the memory is sent: all frames after the head that the client finds have an image.
    if (claim.options.images)
        ring_.want_images(true);
    if (claim.options.confidence)
        ring_.want_confidence(true);
    const Result<ReaderFds> memory = ring_.reader_fds(claim.options.images);
    if (!memory)
        return memory.error();
    epoll_event watched = {0, {.ptr = &place}}; // EPOLLHUP always comes
    if (!send_memory(ours.get(), *memory, ring_.generation()) ||
        ::epoll_ctl(epoll_.get(), EPOLL_CTL_ADD, ours.get(), &watched) < 0)
        return failed(errno);
    place = Stream{std::move(ours), claim, memory->renewal};
    return theirs;
}

int StreamNotifier::close_if(const std::function<bool(const StreamClaim &)> &ends, int error) {
    int ended = 0;
    {
        const std::lock_guard lock(mutex_);
        for (Stream &stream : streams_)
            if (stream.socket && ends(stream.claim)) {
                end(stream, error);
                ++ended;
            }
    }
    if (ended > 0)
        static_cast<void>(renew(true)); // refused by the system: update() tries again
    return ended;
}

bool StreamNotifier::takes_images() const {
    const std::lock_guard lock(mutex_);
    return wished_for(&StreamOptions::images);
}

Status StreamNotifier::update() {
    ::eventfd_t count = 0;
    ::eventfd_read(event_.get(), &count);
    ring_.collect();
    const Status renewed = renew_if_due();
    std::vector<UniqueFd> expensive; // closed when the lock is not held
    const std::lock_guard lock(mutex_);
    expensive.swap(expensive_);
    if (!expensive.empty())
        return Error{fmt::format("a stream of user {} was ended: thousands waited for each of its "
                                 "datagrams, which took the time of the others",
                                 refusals_.front().user),
                     EDQUOT};
    return renewed;
}

Status StreamNotifier::renew_if_due() {
    {
        const std::lock_guard lock(mutex_);
        if (!renewal_due())
            return ok();
    }
    return renew(false);
}

Status StreamNotifier::renew(bool forced) {
    {
        const std::lock_guard lock(mutex_);
        renewal_wanted_ = false; // a stream that ends from here on wants another
        last_renewal_ = Clock::now();
    }
    Status renewed = ring_.renew(forced);
    const std::lock_guard lock(mutex_);
    if (renewed)
        memory_pending_ = true;
    else
        renewal_wanted_ = true;
    wake_thread();
    return renewed;
}

bool StreamNotifier::renewal_due() const {
    return renewal_wanted_ && Clock::now() >= last_renewal_ + renewal_pause;
}

void StreamNotifier::end(Stream &stream, int error) {
    if (error != 0)
        send_end(stream.socket.get(), error);
    stream = Stream{}; // closing it takes it out of the epoll set
    --count_;
    renewal_wanted_ = true;
    pass_on_wishes();
}

void StreamNotifier::end_hung_up() {
    for (Stream &stream : streams_)
        if (stream.socket && hung_up(stream.socket))
            end(stream, 0);
}

void StreamNotifier::pass_on_wishes() {
    ring_.want_images(wished_for(&StreamOptions::images));
    ring_.want_confidence(wished_for(&StreamOptions::confidence));
    ring_.want_interval(shortest_interval());
}

/// Whether a stream was opened with it.
bool StreamNotifier::wished_for(bool StreamOptions::*option) const {
    return std::ranges::any_of(streams_, [&](const Stream &stream) {
        return stream.socket && stream.claim.options.*option;
    });
}

/// Of all streams; 0 while there are none.
milliseconds StreamNotifier::shortest_interval() const {
    std::optional<milliseconds> shortest;
    for (const Stream &stream : streams_)
        if (const milliseconds interval = stream.claim.options.interval; stream.socket)
            shortest = std::min(shortest.value_or(interval), interval);
    return shortest.value_or(milliseconds(0));
}

void StreamNotifier::run() {
    std::array<epoll_event, most_streams + 1> events;
    while (!stop_) {
        const int came = ::epoll_wait(epoll_.get(), events.data(), events.size(), wait_ms());
        if (turn(std::span(events).first(static_cast<std::size_t>(std::max(came, 0)))))
            ::eventfd_write(event_.get(), 1);
    }
}

bool StreamNotifier::turn(std::span<const epoll_event> events) {
    const std::lock_guard lock(mutex_);
    const std::uint64_t head = ring_.head();
    const bool frame = head != announced_;
    announced_ = head;
    bool news = frame;
    if (frame || memory_pending_)
        announce_to_all(head - 1, frame);
    news = news || !expensive_.empty();
    // Asked anew: the place of a stream that has ended may have a new one by now.
    for (const epoll_event &event : events)
        if (auto *stream = static_cast<Stream *>(event.data.ptr);
            stream != nullptr && stream->socket && hung_up(stream->socket)) {
            end(*stream, 0);
            news = true;
        }
    return news || (renewal_due() && count() > 0);
}

void StreamNotifier::announce_to_all(std::uint64_t index, bool frame) {
    memory_pending_ = false;
    nanoseconds before = processor_time();
    for (Stream &stream : streams_) {
        if (!stream.socket)
            continue;
        if (!announce(stream, index, frame))
            memory_pending_ = true;
        const nanoseconds after = processor_time();
        if (stream.excess.add(after - before, fair_cost_))
            end_expensive(stream);
        before = after;
    }
}

/// Without a last datagram, which would take as long.
void StreamNotifier::end_expensive(Stream &stream) {
    std::shift_right(refusals_.begin(), refusals_.end(), 1);
    refusals_.front() = {stream.claim.user, Clock::now() + refusal};
    ::epoll_ctl(epoll_.get(), EPOLL_CTL_DEL, stream.socket.get(), nullptr);
    expensive_.push_back(std::move(stream.socket));
    end(stream, 0);
}

/// False when the stream has to wait for its memory.
bool StreamNotifier::announce(Stream &stream, std::uint64_t index, bool frame) {
    if (stream.renewal != ring_.renewals()) {
        // Only to who has taken everything before: so a stream keeps one pair from being given
        // back by not reading, not one for each renewal.
        if (has_unread(stream.socket.get()))
            return false;
        const Result<ReaderFds> memory = ring_.reader_fds(stream.claim.options.images);
        if (!memory || !send_memory(stream.socket.get(), *memory, ring_.generation()))
            return false;
        stream.renewal = memory->renewal;
    }
    // Failures need no answer: a full socket is that of a slow reader, a closed one hangs up.
    if (frame)
        send_frame(stream.socket.get(), index);
    return true;
}

int StreamNotifier::wait_ms() const {
    const std::lock_guard lock(mutex_);
    if (memory_pending_)
        return retry_pause.count();
    if (!renewal_wanted_ || count() == 0)
        return -1;
    const auto left = std::chrono::ceil<milliseconds>(last_renewal_ + renewal_pause - Clock::now());
    return static_cast<int>((left.count() > 0 ? left : retry_pause).count());
}

} // namespace afterglow
