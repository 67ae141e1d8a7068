// SPDX-License-Identifier: Apache-2.0
#include "ipc/reader/stream_socket.hpp"

#include "core/base/passed_fds.hpp"
#include "ipc/reader/first_version.hpp"

#include <sys/socket.h>

#include <array>
#include <cerrno>

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
    PassedFds<most_descriptors> passed;
    msghdr header = {};
    header.msg_iov = &place;
    header.msg_iovlen = 1;
    passed.make_room(header);
    const ssize_t got = ::recvmsg(socket.get(), &header, MSG_DONTWAIT | MSG_CMSG_CLOEXEC);
    if (got < 0)
        return errno == EAGAIN || errno == EINTR ? StreamMessage{} : ended(-EPIPE);
    if (got == 0)
        return ended(-EPIPE);

    std::array<UniqueFd, 2> memories;
    std::size_t count = 0;
    passed.take(header, [&](UniqueFd fd) {
        if (count < memories.size())
            memories[count++] = std::move(fd);
    });
    StreamMessage message;
    message.kind = Kind::frame;
    if (static_cast<std::size_t>(got) < first_version::message_size)
        return message;
    if (content.type == AFTERGLOW_MESSAGE_END)
        return ended(content.value == EACCES ? -EACCES : -EPIPE);
    if (content.type != AFTERGLOW_MESSAGE_MEMORY)
        return message;
    // Without room for descriptors in this process the kernel leaves them out.
    if (!memories[0])
        return ended((header.msg_flags & MSG_CTRUNC) != 0 ? -EMFILE : -EPROTO);
    message.kind = Kind::memory;
    message.depth = std::move(memories[0]);
    message.images = std::move(memories[1]);
    return message;
}

} // namespace afterglow
