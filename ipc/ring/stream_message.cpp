// SPDX-License-Identifier: Apache-2.0
#include "ipc/ring/stream_message.hpp"

#include "core/base/passed_fds.hpp"

#include <linux/sockios.h>
#include <sys/ioctl.h>
#include <sys/socket.h>

#include <cstring>

namespace afterglow {
namespace {

constexpr int flags = MSG_DONTWAIT | MSG_NOSIGNAL;

afterglow_message message_of(afterglow_message_type type, std::uint64_t value) {
    afterglow_message message = {};
    message.type = type;
    message.size = sizeof message;
    message.value = value;
    return message;
}

bool send(int socket, const afterglow_message &message) {
    return ::send(socket, &message, sizeof message, flags) == sizeof message;
}

} // namespace

bool send_frame(int socket, std::uint64_t index) {
    return send(socket, message_of(AFTERGLOW_MESSAGE_FRAME, index));
}

bool send_memory(int socket, const ReaderFds &memory, std::uint64_t generation) {
    const int fds[] = {memory.depth.get(), memory.images.get()};
    PassedFds<2> passed;
    afterglow_message message = message_of(AFTERGLOW_MESSAGE_MEMORY, generation);
    iovec content = {&message, sizeof message};
    msghdr header = {};
    header.msg_iov = &content;
    header.msg_iovlen = 1;
    passed.attach(header, std::span(fds).first(memory.images ? 2 : 1));
    return ::sendmsg(socket, &header, flags) == sizeof message;
}

bool send_end(int socket, int error) {
    const int room = 1 << 16;
    ::setsockopt(socket, SOL_SOCKET, SO_SNDBUF, &room, sizeof room);
    return send(socket, message_of(AFTERGLOW_MESSAGE_END, static_cast<std::uint64_t>(error)));
}

bool has_unread(int socket) {
    int bytes = 0;
    return ::ioctl(socket, SIOCOUTQ, &bytes) < 0 || bytes > 0;
}

} // namespace afterglow
