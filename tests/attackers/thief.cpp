// SPDX-License-Identifier: Apache-2.0
#include "tests/attackers/attack.hpp"

#include <climits>
#include <linux/futex.h>
#include <sys/socket.h>
#include <sys/syscall.h>

#include <cstdint>
#include <unistd.h>

namespace afterglow::attack {
namespace {

/// Takes everybody who waits on a word of the memory away to a word of ours.
void steal_waiters(const Memory &memory) {
    static std::uint32_t ours = 0;
    const auto *words = reinterpret_cast<const std::uint32_t *>(memory.at);
    for (std::size_t i = 0; i < memory.header().header_size / 4; ++i) {
        ::syscall(SYS_futex, words + i, FUTEX_REQUEUE, 0, INT_MAX, &ours, 0);
        ::syscall(SYS_futex, words + i, FUTEX_WAKE, INT_MAX, nullptr, nullptr, 0);
    }
}

/// Sends what the daemon never asked for, with descriptors; and takes from the socket what is
/// there.
void misuse_socket(int socket) {
    char data[64] = {};
    ::recv(socket, data, sizeof data, MSG_DONTWAIT | MSG_PEEK);
    ::recv(socket, data, sizeof data, MSG_DONTWAIT);
    if (::send(socket, data, sizeof data, MSG_DONTWAIT | MSG_NOSIGNAL) >= 0)
        say("broken: the daemon's end can be written to");
    alignas(cmsghdr) char control[CMSG_SPACE(sizeof(int))] = {};
    iovec part = {data, 1};
    msghdr message = {};
    message.msg_iov = &part;
    message.msg_iovlen = 1;
    message.msg_control = control;
    message.msg_controllen = sizeof control;
    cmsghdr *rights = CMSG_FIRSTHDR(&message);
    *rights = {CMSG_LEN(sizeof(int)), SOL_SOCKET, SCM_RIGHTS};
    *reinterpret_cast<int *>(CMSG_DATA(rights)) = socket;
    if (::sendmsg(socket, &message, MSG_DONTWAIT | MSG_NOSIGNAL) >= 0)
        say("broken: the daemon can be sent descriptors");
}

} // namespace

/// Tries to take other readers' wake-ups and to fill the daemon's queues, as fast as it can.
int thief(const std::string &from) {
    const UniqueFd socket = open_stream(from);
    std::vector<Memory> memories = first_memories(socket.get());
    say("ready");
    for (;;) {
        for (const Memory &memory : memories)
            steal_waiters(memory);
        misuse_socket(socket.get());
    }
}

} // namespace afterglow::attack
