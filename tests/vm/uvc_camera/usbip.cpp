// SPDX-License-Identifier: Apache-2.0
#include "tests/vm/uvc_camera/usbip.hpp"

#include <sys/socket.h>

#include <arpa/inet.h>
#include <cerrno>
#include <cstdio>
#include <cstring>
#include <fcntl.h>
#include <string>

namespace afterglow::vm {
namespace {

/// The header of every message: 12 words, big-endian, of which a submit's last two are the setup.
using Header = std::array<std::uint32_t, 12>;
enum : std::uint32_t { cmd_submit = 1, cmd_unlink = 2, ret_submit = 3, ret_unlink = 4 };

constexpr std::uint32_t high_speed = 3;
constexpr std::uint32_t out = 0;
constexpr std::uint32_t max_packets = 1024;
constexpr std::uint32_t max_length = 1 << 22;

std::uint32_t word(std::int32_t value) {
    return htonl(static_cast<std::uint32_t>(value));
}

} // namespace

std::optional<UsbipPort> UsbipPort::plug_in(int port) {
    int ends[2];
    if (::socketpair(AF_UNIX, SOCK_STREAM, 0, ends) != 0)
        return std::nullopt;
    UniqueFd ours(ends[0]);
    UniqueFd hosts(ends[1]);
    // A transfer's data must fit, or each side could wait for the other to read.
    const int room = 8 << 20;
    ::setsockopt(ours.get(), SOL_SOCKET, SO_SNDBUFFORCE, &room, sizeof room);
    ::setsockopt(hosts.get(), SOL_SOCKET, SO_SNDBUFFORCE, &room, sizeof room);

    const std::string request = std::to_string(port) + " " + std::to_string(hosts.get()) + " " +
                                std::to_string(0x10001 + port) + " " + std::to_string(high_speed);
    UniqueFd attach(::open("/sys/devices/platform/vhci_hcd.0/attach", O_WRONLY | O_CLOEXEC));
    if (!attach || ::write(attach.get(), request.data(), request.size()) < 0)
        return std::nullopt;
    return UsbipPort(std::move(ours));
}

std::optional<Transfer> UsbipPort::receive() {
    Header header;
    if (!read(header.data(), sizeof header))
        return std::nullopt;
    Transfer transfer;
    transfer.sequence = ntohl(header[1]);
    if (ntohl(header[0]) == cmd_unlink) {
        transfer.unlink = true;
        transfer.unlinked = ntohl(header[5]);
        return transfer;
    }
    transfer.endpoint = ntohl(header[4]);
    transfer.length = ntohl(header[6]);
    transfer.start_frame = header[7];
    const std::uint32_t packets = ntohl(header[8]);
    std::memcpy(transfer.setup.data(), &header[10], transfer.setup.size());
    if (transfer.length > max_length)
        return std::nullopt;
    if (ntohl(header[3]) == out && transfer.length > 0) {
        transfer.data.resize(transfer.length);
        if (!read(transfer.data.data(), transfer.data.size()))
            return std::nullopt;
    }
    if (transfer.endpoint != 0 && packets <= max_packets) {
        transfer.packets.resize(packets);
        for (IsoPacket &packet : transfer.packets) {
            std::array<std::uint32_t, 4> words;
            if (!read(words.data(), sizeof words))
                return std::nullopt;
            packet.offset = ntohl(words[0]);
            packet.length = ntohl(words[1]);
        }
    }
    return transfer;
}

void UsbipPort::answer(const Transfer &transfer, std::span<const std::uint8_t> data) {
    data = data.first(std::min<std::size_t>(data.size(), transfer.length));
    reply(transfer, 0, static_cast<std::uint32_t>(data.size()), data);
}

void UsbipPort::accept(const Transfer &transfer) {
    reply(transfer, 0, transfer.length, {});
}

void UsbipPort::stall(const Transfer &transfer) {
    reply(transfer, -EPIPE, 0, {});
}

void UsbipPort::complete(const Transfer &transfer, std::span<const std::uint8_t> data) {
    reply(transfer, 0, static_cast<std::uint32_t>(data.size()), data);
}

void UsbipPort::unlinked(const Transfer &unlink, bool found) {
    Header header{};
    header[0] = htonl(ret_unlink);
    header[1] = htonl(unlink.sequence);
    header[5] = word(found ? -ECONNRESET : 0);
    write({reinterpret_cast<const std::uint8_t *>(header.data()), sizeof header});
}

void UsbipPort::reply(const Transfer &transfer, std::int32_t status, std::uint32_t actual_length,
                      std::span<const std::uint8_t> data) {
    std::vector<std::uint8_t> message;
    const auto append = [&message](const auto &words) {
        const auto *bytes = reinterpret_cast<const std::uint8_t *>(words.data());
        message.insert(message.end(), bytes, bytes + sizeof words);
    };
    std::int32_t errors = 0;
    for (const IsoPacket &packet : transfer.packets)
        errors += packet.status != 0 ? 1 : 0;
    append(Header{htonl(ret_submit), htonl(transfer.sequence), 0, 0, 0, word(status),
                  htonl(actual_length), transfer.start_frame,
                  htonl(static_cast<std::uint32_t>(transfer.packets.size())), word(errors), 0, 0});
    message.insert(message.end(), data.begin(), data.end());
    for (const IsoPacket &packet : transfer.packets)
        append(std::array<std::uint32_t, 4>{htonl(packet.offset), htonl(packet.length),
                                            htonl(packet.actual_length), word(packet.status)});
    write(message);
}

bool UsbipPort::read(void *to, std::size_t size) {
    auto *bytes = static_cast<std::uint8_t *>(to);
    while (size > 0) {
        const ssize_t got = ::recv(socket_.get(), bytes, size, 0);
        if (got <= 0)
            return false;
        bytes += got;
        size -= static_cast<std::size_t>(got);
    }
    return true;
}

void UsbipPort::write(std::span<const std::uint8_t> bytes) {
    while (!bytes.empty()) {
        const ssize_t sent = ::send(socket_.get(), bytes.data(), bytes.size(), MSG_NOSIGNAL);
        if (sent <= 0)
            return; // the host is gone, which the next receive() finds
        bytes = bytes.subspan(static_cast<std::size_t>(sent));
    }
}

} // namespace afterglow::vm
