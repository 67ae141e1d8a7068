// SPDX-License-Identifier: Apache-2.0
#include "tests/vm/uvc_camera/controls.hpp"

#include "tests/vm/uvc_camera/descriptors.hpp"

#include <algorithm>
#include <cstring>

namespace afterglow::vm {
namespace {

// USB 2.0, section 9.4; USB Video Class 1.0, section A.8.
enum : std::uint8_t {
    get_status = 0,
    get_descriptor = 6,
    get_configuration = 8,
    get_interface = 10,
    set_interface = 11,
    set_cur = 0x01,
    get_cur = 0x81,
    get_min = 0x82,
    get_max = 0x83,
    get_res = 0x84,
    get_len = 0x85,
    get_info = 0x86,
    get_def = 0x87,
};
enum : std::uint8_t { probe_control = 1, commit_control = 2 };

/// A control of a unit: how many bytes, and the numbers it takes.
struct Range {
    int unit;
    int selector;
    std::uint8_t bytes;
    std::uint32_t least;
    std::uint32_t most;
    std::uint32_t step;
    std::uint32_t usual;
};
constexpr std::array ranges = {
    Range{camera_terminal, 2, 1, 1, 8, 9, 8},      // exposure mode: 1 manual, 8 by aperture
    Range{camera_terminal, 3, 1, 0, 1, 1, 1},      // exposure priority: 1 = frames may grow long
    Range{camera_terminal, 4, 4, 1, 5000, 1, 156}, // exposure time, 100 us
    Range{processing_unit, 2, 2, 0, 255, 1, 128},  // brightness
};

std::vector<std::uint8_t> little_endian(std::uint32_t value, std::size_t bytes) {
    std::vector<std::uint8_t> out;
    for (std::size_t i = 0; i < bytes; ++i)
        out.push_back(static_cast<std::uint8_t>(value >> 8 * i));
    return out;
}

std::uint32_t number(std::span<const std::uint8_t> bytes) {
    std::uint32_t value = 0;
    for (std::size_t i = 0; i < std::min<std::size_t>(bytes.size(), 4); ++i)
        value |= std::uint32_t{bytes[i]} << 8 * i;
    return value;
}

/// The probe and commit structure, 26 bytes.
std::vector<std::uint8_t> encode(const StreamChoice &choice) {
    std::vector<std::uint8_t> bytes(26);
    const UvcSize &size = uvc_sizes[choice.size];
    const std::uint32_t frame =
        std::uint32_t{size.width} * size.height * uvc_formats[choice.format].bytes_per_pixel;
    // Packets in 125 us each, and a twentieth more, so that a frame is out before the next begins.
    const double needed = frame * (1e7 / choice.interval) * 1.05 / 8000;
    const std::uint32_t packet = needed < 1000 ? packet_bytes[1] : packet_bytes[2];
    bytes[2] = static_cast<std::uint8_t>(choice.format + 1);
    bytes[3] = static_cast<std::uint8_t>(choice.size + 1);
    const auto put = [&bytes](std::size_t at, std::uint32_t value) {
        const auto encoded = little_endian(value, 4);
        std::copy(encoded.begin(), encoded.end(), bytes.begin() + static_cast<std::ptrdiff_t>(at));
    };
    put(4, choice.interval);
    put(18, frame);
    put(22, packet);
    return bytes;
}

StreamChoice decode(std::span<const std::uint8_t> bytes) {
    StreamChoice choice;
    if (bytes.size() < 8)
        return choice;
    choice.format = std::clamp<std::size_t>(bytes[2], 1, uvc_formats.size()) - 1;
    choice.size = std::clamp<std::size_t>(bytes[3], 1, uvc_sizes.size()) - 1;
    const std::uint32_t wished = number(bytes.subspan(4, 4));
    for (const std::uint32_t interval : uvc_intervals) {
        choice.interval = interval;
        if (interval >= wished)
            break;
    }
    return choice;
}

} // namespace

bool Controls::handle(const Transfer &transfer, UsbipPort &port) {
    const std::uint8_t type = transfer.setup[0] & 0x60;
    if (type == 0)
        return handle_standard(transfer, port);
    const std::uint8_t interface = transfer.setup[4];
    if (type == 0x20 && interface == 1)
        handle_probe(transfer, port);
    else if (type == 0x20 && interface == 0)
        handle_unit(transfer, port);
    else
        port.stall(transfer);
    return false;
}

bool Controls::handle_standard(const Transfer &transfer, UsbipPort &port) {
    const std::uint8_t value = transfer.setup[2];
    const std::uint8_t kind = transfer.setup[3];
    const bool is_in = (transfer.setup[0] & 0x80) != 0;
    switch (transfer.setup[1]) {
    case get_descriptor:
        if (kind == 1)
            port.answer(transfer, device_descriptor());
        else if (kind == 2)
            port.answer(transfer, configuration_descriptor());
        else if (kind == 3)
            port.answer(transfer, string_descriptor(value, serial_));
        else
            port.stall(transfer); // a high-speed device only
        return false;
    case get_status:
        port.answer(transfer, little_endian(0, 2));
        return false;
    case get_configuration:
        port.answer(transfer, little_endian(1, 1));
        return false;
    case get_interface:
        port.answer(transfer, little_endian(alternate_, 1));
        return false;
    case set_interface:
        port.accept(transfer);
        if (transfer.setup[4] != 1)
            return false;
        alternate_ = value;
        return true;
    default:
        if (is_in)
            port.stall(transfer);
        else
            port.accept(transfer); // set_configuration, clear_feature
        return false;
    }
}

void Controls::handle_probe(const Transfer &transfer, UsbipPort &port) {
    const std::uint8_t control = transfer.setup[3];
    if (control != probe_control && control != commit_control)
        return port.stall(transfer);
    StreamChoice &choice = control == probe_control ? probed_ : committed_;
    switch (transfer.setup[1]) {
    case set_cur:
        choice = decode(transfer.data);
        return port.accept(transfer);
    case get_len:
        return port.answer(transfer, little_endian(26, 2));
    case get_info:
        return port.answer(transfer, little_endian(3, 1));
    default:
        return port.answer(transfer, encode(choice));
    }
}

void Controls::handle_unit(const Transfer &transfer, UsbipPort &port) {
    const int unit = transfer.setup[5];
    const int selector = transfer.setup[3];
    const auto range = std::find_if(ranges.begin(), ranges.end(), [&](const Range &known) {
        return known.unit == unit && known.selector == selector;
    });
    if (range == ranges.end())
        return port.stall(transfer);
    const int key = unit << 8 | selector;
    const auto answer = [&](std::uint32_t value) {
        port.answer(transfer, little_endian(value, range->bytes));
    };
    switch (transfer.setup[1]) {
    case set_cur:
        values_[key] = number(transfer.data);
        return port.accept(transfer);
    case get_cur:
        return answer(values_.count(key) != 0 ? values_[key] : range->usual);
    case get_min:
        return answer(range->least);
    case get_max:
        return answer(range->most);
    case get_res:
        return answer(range->step);
    case get_def:
        return answer(range->usual);
    case get_len:
        return port.answer(transfer, little_endian(range->bytes, 2));
    case get_info:
        return port.answer(transfer, little_endian(3, 1));
    default:
        return port.stall(transfer);
    }
}

} // namespace afterglow::vm
