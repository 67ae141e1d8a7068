// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "core/base/unique_fd.hpp"

#include <array>
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

namespace afterglow::vm {

/// One packet of an isochronous transfer, as USB/IP describes it; host byte order.
struct IsoPacket {
    std::uint32_t offset = 0;
    std::uint32_t length = 0;
    std::uint32_t actual_length = 0;
    std::int32_t status = 0;
};

/// A transfer that the host asks for, or the request to give one up.
struct Transfer {
    bool unlink = false;
    std::uint32_t sequence = 0;
    std::uint32_t unlinked = 0; ///< of an unlink: the sequence of the transfer given up
    std::uint32_t endpoint = 0;
    std::uint32_t length = 0;
    std::uint32_t start_frame = 0;
    std::array<std::uint8_t, 8> setup{};
    std::vector<std::uint8_t> data; ///< from the host
    std::vector<IsoPacket> packets; ///< none: not isochronous
};

/// The device's end of a port of vhci_hcd, the kernel's virtual USB host controller: the USB/IP
/// protocol (Documentation/usb/usbip_protocol.rst) over a socket pair, no network.
class UsbipPort {
public:
    /// Plugs a high-speed device into the port. Nothing, and errno, where that fails.
    static std::optional<UsbipPort> plug_in(int port);

    int fd() const { return socket_.get(); }
    /// Reads what the host wants next; nothing when it has closed the port.
    std::optional<Transfer> receive();
    /// Completes a control transfer with an answer.
    void answer(const Transfer &transfer, std::span<const std::uint8_t> data);
    /// Completes a control transfer that sent data, or none.
    void accept(const Transfer &transfer);
    /// Refuses a control transfer.
    void stall(const Transfer &transfer);
    /// Completes an isochronous transfer; `data` holds the packets' bytes without gaps.
    void complete(const Transfer &transfer, std::span<const std::uint8_t> data);
    /// Says whether the transfer was still there to be given up.
    void unlinked(const Transfer &unlink, bool found);

private:
    explicit UsbipPort(UniqueFd socket) : socket_(std::move(socket)) {}
    bool read(void *to, std::size_t size);
    void write(std::span<const std::uint8_t> bytes);
    void reply(const Transfer &transfer, std::int32_t status, std::uint32_t actual_length,
               std::span<const std::uint8_t> data);

    UniqueFd socket_;
};

} // namespace afterglow::vm
