// SPDX-License-Identifier: Apache-2.0
#include "ipc/stream_sockets.hpp"

#include <fmt/format.h>
#include <sys/epoll.h>
#include <sys/socket.h>

#include <algorithm>
#include <cerrno>
#include <cstring>

namespace afterglow {

struct StreamSockets::Stream {
    StreamSockets &owner;
    UniqueFd socket;
    uid_t user;
    sd_event_source *hang_up = nullptr;

    Stream(StreamSockets &sockets, UniqueFd fd, uid_t uid)
        : owner(sockets), socket(std::move(fd)), user(uid) {}
    Stream(const Stream &) = delete;
    ~Stream() { sd_event_source_disable_unref(hang_up); }
};

StreamSockets::StreamSockets(sd_event *event, std::function<void(int)> changed)
    : event_(sd_event_ref(event)), changed_(std::move(changed)) {}

StreamSockets::~StreamSockets() {
    streams_.clear();
    sd_event_unref(event_);
}

Result<UniqueFd> StreamSockets::open(uid_t user) {
    const auto of_user = std::count_if(streams_.begin(), streams_.end(),
                                       [&](const Stream &stream) { return stream.user == user; });
    if (count() >= most_streams)
        return Error{fmt::format("All {} streams are open.", most_streams), EDQUOT};
    if (of_user >= most_streams_of_a_user)
        return Error{fmt::format("User {} has {} streams open, the most that one user may have.",
                                 user, of_user),
                     EDQUOT};
    const auto failed = [](int code) {
        return Error{fmt::format("Cannot open a stream: {}.", std::strerror(code)), code};
    };
    int ends[2];
    if (::socketpair(AF_UNIX, SOCK_SEQPACKET | SOCK_CLOEXEC | SOCK_NONBLOCK, 0, ends) < 0)
        return failed(errno);
    UniqueFd ours(ends[0]);
    UniqueFd theirs(ends[1]);
    // A wake-up that waits for long says nothing. The kernel makes of it what its least is.
    const int least = 1;
    if (::setsockopt(ours.get(), SOL_SOCKET, SO_SNDBUF, &least, sizeof least) < 0 ||
        ::shutdown(ours.get(), SHUT_RD) < 0)
        return failed(errno);
    Stream &stream = streams_.emplace_back(*this, std::move(ours), user);
    if (const int error = sd_event_add_io(event_, &stream.hang_up, stream.socket.get(), EPOLLHUP,
                                          on_hang_up, &stream);
        error < 0) {
        streams_.pop_back();
        return failed(-error);
    }
    changed_(count());
    return theirs;
}

void StreamSockets::wake(std::uint64_t frame_index) {
    // Failures need no answer: a full socket is that of a slow reader, a closed one hangs up.
    for (const Stream &stream : streams_)
        ::send(stream.socket.get(), &frame_index, sizeof frame_index, MSG_DONTWAIT | MSG_NOSIGNAL);
}

int StreamSockets::on_hang_up(sd_event_source * /*source*/, int /*fd*/, std::uint32_t /*events*/,
                              void *stream) {
    StreamSockets &sockets = static_cast<Stream *>(stream)->owner;
    sockets.streams_.remove_if([&](const Stream &ended) { return &ended == stream; });
    sockets.changed_(sockets.count());
    return 0;
}

} // namespace afterglow
