// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "core/base/unique_fd.hpp"

#include <sys/socket.h>

#include <cstddef>
#include <cstring>
#include <span>

namespace afterglow {

/// Up to `most` file descriptors that go with a datagram of a Unix socket (SCM_RIGHTS). It holds
/// the message's control data, so it must live until sendmsg() or recvmsg() returns.
template <std::size_t most>
class PassedFds {
public:
    /// `message` will be sent with `fds`, which stay the caller's. With none it has no control
    /// data.
    void attach(msghdr &message, std::span<const int> fds) {
        if (fds.empty())
            return;
        message.msg_control = control_;
        message.msg_controllen = CMSG_SPACE(fds.size_bytes());
        cmsghdr *rights = CMSG_FIRSTHDR(&message);
        rights->cmsg_level = SOL_SOCKET;
        rights->cmsg_type = SCM_RIGHTS;
        rights->cmsg_len = CMSG_LEN(fds.size_bytes());
        std::memcpy(CMSG_DATA(rights), fds.data(), fds.size_bytes());
    }

    /// `message` may be received with descriptors. The kernel closes those that find no room here,
    /// and sets MSG_CTRUNC.
    void make_room(msghdr &message) {
        message.msg_control = control_;
        message.msg_controllen = sizeof control_;
    }

    /// Calls use(UniqueFd) for each descriptor that came with a received `message`, in their order.
    template <class Use>
    static void take(msghdr &message, const Use &use) {
        for (cmsghdr *part = CMSG_FIRSTHDR(&message); part != nullptr;
             part = CMSG_NXTHDR(&message, part)) {
            if (part->cmsg_level != SOL_SOCKET || part->cmsg_type != SCM_RIGHTS)
                continue;
            const std::size_t bytes = part->cmsg_len - CMSG_LEN(0);
            for (std::size_t at = 0; at + sizeof(int) <= bytes; at += sizeof(int)) {
                int fd = -1;
                std::memcpy(&fd, CMSG_DATA(part) + at, sizeof fd);
                use(UniqueFd(fd));
            }
        }
    }

private:
    alignas(cmsghdr) char control_[CMSG_SPACE(most * sizeof(int))] = {};
};

} // namespace afterglow
