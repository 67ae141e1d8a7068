// SPDX-License-Identifier: Apache-2.0
#include "ipc/reader/stream_socket.hpp"

#include "ipc/reader/first_version.hpp"

#include <sys/socket.h>

#include <array>
#include <cerrno>
#include <cstring>

namespace afterglow {
namespace {

using Kind = StreamMessage::Kind;

/// Later versions may send more memories than this library knows. The kernel closes what finds no
/// room here.
constexpr std::size_t most_descriptors = 8;

StreamMessage ended(int error) {
    StreamMessage message;
    message.kind = Kind::end;
    message.error = error;
    return message;
}

/// The descriptors that came with a datagram.
std::array<UniqueFd, most_descriptors> take_descriptors(msghdr &header) {
    std::array<UniqueFd, most_descriptors> taken;
    std::size_t count = 0;
    for (cmsghdr *part = CMSG_FIRSTHDR(&header); part != nullptr;
         part = CMSG_NXTHDR(&header, part)) {
        if (part->cmsg_level != SOL_SOCKET || part->cmsg_type != SCM_RIGHTS)
            continue;
        const std::size_t bytes = part->cmsg_len - CMSG_LEN(0);
        for (std::size_t at = 0; at + sizeof(int) <= bytes; at += sizeof(int)) {
            int fd = -1;
            std::memcpy(&fd, CMSG_DATA(part) + at, sizeof fd);
            UniqueFd owned(fd);
            if (count < taken.size())
                taken[count++] = std::move(owned);
        }
    }
    return taken;
}

} // namespace

int check_stream_socket(const UniqueFd &socket) {
    int type = 0;
    socklen_t size = sizeof type;
    if (::getsockopt(socket.get(), SOL_SOCKET, SO_TYPE, &type, &size) < 0)
        return errno == ENOTSOCK ? -EPROTO : -errno;
    return type == SOCK_SEQPACKET ? 0 : -EPROTO;
}

StreamMessage receive(const UniqueFd &socket) {
    afterglow_message content{};
    iovec place = {&content, sizeof content};
    alignas(cmsghdr) char control[CMSG_SPACE(most_descriptors * sizeof(int))];
    msghdr header = {};
    header.msg_iov = &place;
    header.msg_iovlen = 1;
    header.msg_control = control;
    header.msg_controllen = sizeof control;
    const ssize_t got = ::recvmsg(socket.get(), &header, MSG_DONTWAIT | MSG_CMSG_CLOEXEC);
    if (got < 0)
        return errno == EAGAIN || errno == EINTR ? StreamMessage{} : ended(-EPIPE);
    if (got == 0)
        return ended(-EPIPE);

    auto descriptors = take_descriptors(header);
    StreamMessage message;
    message.kind = Kind::frame;
    if (static_cast<std::size_t>(got) < first_version::message_size)
        return message;
    if (content.type == AFTERGLOW_MESSAGE_END)
        return ended(content.value == EACCES ? -EACCES : -EPIPE);
    if (content.type != AFTERGLOW_MESSAGE_MEMORY)
        return message;
    // Without room for descriptors in this process the kernel leaves them out.
    if (!descriptors[0])
        return ended((header.msg_flags & MSG_CTRUNC) != 0 ? -EMFILE : -EPROTO);
    message.kind = Kind::memory;
    message.depth = std::move(descriptors[0]);
    message.images = std::move(descriptors[1]);
    return message;
}

} // namespace afterglow
