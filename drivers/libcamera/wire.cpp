// SPDX-License-Identifier: Apache-2.0
#include "drivers/libcamera/wire.hpp"

#include <sys/socket.h>

#include <algorithm>
#include <cerrno>
#include <cstring>

namespace afterglow::libcam {

namespace {

/// A message's descriptors, as the kernel wants them beside it.
union Ancillary {
    cmsghdr header;
    char bytes[CMSG_SPACE(max_buffers * sizeof(int))];
};

} // namespace

void Report::set_text(std::string_view words) {
    text = {};
    std::copy_n(words.begin(), std::min(words.size(), text.size() - 1), text.begin());
}

bool send(int socket, const Report &report, std::span<const int> descriptors) {
    iovec part = {const_cast<Report *>(&report), sizeof report};
    Ancillary ancillary = {};
    msghdr message = {};
    message.msg_iov = &part;
    message.msg_iovlen = 1;
    if (!descriptors.empty()) {
        message.msg_control = &ancillary;
        message.msg_controllen = CMSG_SPACE(descriptors.size_bytes());
        cmsghdr *header = CMSG_FIRSTHDR(&message);
        header->cmsg_level = SOL_SOCKET;
        header->cmsg_type = SCM_RIGHTS;
        header->cmsg_len = CMSG_LEN(descriptors.size_bytes());
        std::memcpy(CMSG_DATA(header), descriptors.data(), descriptors.size_bytes());
    }
    ssize_t sent = 0;
    do
        sent = ::sendmsg(socket, &message, MSG_NOSIGNAL);
    while (sent < 0 && errno == EINTR);
    return sent == static_cast<ssize_t>(sizeof report);
}

Received receive(int socket, Report &report, std::vector<UniqueFd> &descriptors) {
    iovec part = {&report, sizeof report};
    Ancillary ancillary = {};
    msghdr message = {};
    message.msg_iov = &part;
    message.msg_iovlen = 1;
    message.msg_control = &ancillary;
    message.msg_controllen = sizeof ancillary;
    ssize_t got = 0;
    do
        got = ::recvmsg(socket, &message, MSG_DONTWAIT | MSG_CMSG_CLOEXEC);
    while (got < 0 && errno == EINTR);
    if (got < 0 && errno == EAGAIN)
        return Received::nothing;
    descriptors.clear();
    for (cmsghdr *header = got > 0 ? CMSG_FIRSTHDR(&message) : nullptr; header != nullptr;
         header = CMSG_NXTHDR(&message, header)) {
        if (header->cmsg_level != SOL_SOCKET || header->cmsg_type != SCM_RIGHTS)
            continue;
        const std::size_t count = (header->cmsg_len - CMSG_LEN(0)) / sizeof(int);
        for (std::size_t i = 0; i < count; ++i) {
            int descriptor = -1;
            std::memcpy(&descriptor, CMSG_DATA(header) + i * sizeof(int), sizeof(int));
            descriptors.emplace_back(descriptor);
        }
    }
    if (got != static_cast<ssize_t>(sizeof report) || (message.msg_flags & MSG_CTRUNC) != 0)
        return Received::end;
    report.text.back() = '\0';
    return Received::message;
}

} // namespace afterglow::libcam
