// SPDX-License-Identifier: Apache-2.0
#include "drivers/libcamera/wire.hpp"

#include "core/base/passed_fds.hpp"

#include <sys/socket.h>

#include <algorithm>
#include <cerrno>
#include <utility>

namespace afterglow::libcam {

void Report::set_text(std::string_view words) {
    text = {};
    std::copy_n(words.begin(), std::min(words.size(), text.size() - 1), text.begin());
}

bool send(int socket, const Report &report, std::span<const int> descriptors) {
    iovec part = {const_cast<Report *>(&report), sizeof report};
    PassedFds<max_buffers> passed;
    msghdr message = {};
    message.msg_iov = &part;
    message.msg_iovlen = 1;
    passed.attach(message, descriptors);
    ssize_t sent = 0;
    do
        sent = ::sendmsg(socket, &message, MSG_NOSIGNAL);
    while (sent < 0 && errno == EINTR);
    return sent == static_cast<ssize_t>(sizeof report);
}

Received receive(int socket, Report &report, std::vector<UniqueFd> &descriptors) {
    iovec part = {&report, sizeof report};
    PassedFds<max_buffers> passed;
    msghdr message = {};
    message.msg_iov = &part;
    message.msg_iovlen = 1;
    passed.make_room(message);
    ssize_t got = 0;
    do
        got = ::recvmsg(socket, &message, MSG_DONTWAIT | MSG_CMSG_CLOEXEC);
    while (got < 0 && errno == EINTR);
    if (got < 0 && errno == EAGAIN)
        return Received::nothing;
    descriptors.clear();
    if (got > 0)
        passed.take(message, [&](UniqueFd fd) { descriptors.push_back(std::move(fd)); });
    if (got != static_cast<ssize_t>(sizeof report) || (message.msg_flags & MSG_CTRUNC) != 0)
        return Received::end;
    report.text.back() = '\0';
    return Received::message;
}

} // namespace afterglow::libcam
