// SPDX-License-Identifier: Apache-2.0
#include "tests/vm/uvc_camera/descriptors.hpp"

#include <initializer_list>

namespace afterglow::vm {
namespace {

// USB 2.0, section 9.6; USB Video Class 1.0, sections 3.7 to 3.9.
enum : std::uint8_t {
    device = 1,
    configuration = 2,
    string = 3,
    interface = 4,
    endpoint = 5,
    association = 11,
    class_interface = 0x24,
    video_class = 0x0e,
    video_control = 1,
    video_streaming = 2,
    video_function = 3,
};

/// Bytes in the making; numbers are little-endian.
class Bytes {
public:
    Bytes &u8(std::initializer_list<int> values) {
        for (const int value : values)
            bytes_.push_back(static_cast<std::uint8_t>(value));
        return *this;
    }
    Bytes &u16(std::uint32_t value) {
        return u8({static_cast<int>(value & 0xff), static_cast<int>(value >> 8 & 0xff)});
    }
    Bytes &u32(std::uint32_t value) { return u16(value & 0xffff).u16(value >> 16); }
    /// Appends a descriptor, its length before it.
    Bytes &add(const Bytes &body) {
        u8({static_cast<int>(body.bytes_.size() + 1)});
        bytes_.insert(bytes_.end(), body.bytes_.begin(), body.bytes_.end());
        return *this;
    }
    std::size_t size() const { return bytes_.size(); }
    /// Writes the number of bytes from `begin` on into the 16 bits at `at`.
    void set_length(std::size_t at, std::size_t begin) {
        bytes_[at] = static_cast<std::uint8_t>((size() - begin) & 0xff);
        bytes_[at + 1] = static_cast<std::uint8_t>((size() - begin) >> 8);
    }
    Descriptor take() { return std::move(bytes_); }

private:
    Descriptor bytes_;
};

void add_control_interface(Bytes &to) {
    to.add(Bytes().u8({interface, 0, 0, 0, video_class, video_control, 0, 0}));
    const std::size_t begin = to.size();
    to.add(Bytes().u8({class_interface, 1}).u16(0x100).u16(0).u32(48'000'000).u8({1, 1}));
    // Exposure mode, exposure priority (the control that lets frames grow long), exposure time.
    to.add(Bytes()
               .u8({class_interface, 2, camera_terminal})
               .u16(0x0201)
               .u8({0, 0, 0, 0, 0, 0, 0, 0, 3, 0x0e, 0, 0}));
    to.add(Bytes().u8({class_interface, 5, processing_unit, camera_terminal, 0, 0, 2, 0x01, 0, 0}));
    to.add(Bytes().u8({class_interface, 3, 3}).u16(0x0101).u8({0, processing_unit, 0}));
    to.set_length(begin + 5, begin);
}

void add_frame(Bytes &to, int index, const UvcSize &size, std::uint32_t bytes_per_pixel) {
    const std::uint32_t bytes = std::uint32_t{size.width} * size.height * bytes_per_pixel;
    Bytes frame;
    frame.u8({class_interface, 5, index, 0}).u16(size.width).u16(size.height);
    frame.u32(bytes * 8 * 15).u32(bytes * 8 * 60).u32(bytes).u32(uvc_intervals[1]);
    frame.u8({static_cast<int>(uvc_intervals.size())});
    for (const std::uint32_t interval : uvc_intervals)
        frame.u32(interval);
    to.add(frame);
}

void add_format(Bytes &to, int index, const UvcFormat &format) {
    Bytes body;
    body.u8({class_interface, 4, index, static_cast<int>(uvc_sizes.size())});
    for (const char letter : format.code)
        body.u8({letter});
    body.u8({0, 0, 0x10, 0, 0x80, 0, 0, 0xaa, 0, 0x38, 0x9b, 0x71}); // the rest of the GUID
    body.u8({format.bytes_per_pixel * 8, 1, 0, 0, 0, 0});
    to.add(body);
    int number = 1;
    for (const UvcSize &size : uvc_sizes)
        add_frame(to, number++, size, format.bytes_per_pixel);
    to.add(Bytes().u8({class_interface, 13, 1, 1, 4})); // colours of BT.709
}

void add_streaming_interface(Bytes &to) {
    const int formats = static_cast<int>(uvc_formats.size());
    to.add(Bytes().u8({interface, 1, 0, 0, video_class, video_streaming, 0, 0}));
    const std::size_t begin = to.size();
    Bytes header;
    header.u8({class_interface, 1, formats}).u16(0).u8({0x81, 0, 3, 0, 0, 0, 1});
    for (int i = 0; i < formats; ++i)
        header.u8({0});
    to.add(header);
    int number = 1;
    for (const UvcFormat &format : uvc_formats)
        add_format(to, number++, format);
    to.set_length(begin + 4, begin);
    for (int alternate = 1; alternate < static_cast<int>(packet_bytes.size()); ++alternate) {
        to.add(Bytes().u8({interface, 1, alternate, 1, video_class, video_streaming, 0, 0}));
        // Isochronous, asynchronous; 1 or 3 packets of 1024 bytes a microframe.
        const std::uint32_t more = packet_bytes[static_cast<std::size_t>(alternate)] / 1024 - 1;
        to.add(Bytes().u8({endpoint, 0x81, 5}).u16(more << 11 | 1024).u8({1}));
    }
}

} // namespace

Descriptor device_descriptor() {
    Bytes body;
    body.u8({device}).u16(0x200).u8({0xef, 2, 1, 64}).u16(0x1d6b).u16(0x0102).u16(0x100);
    body.u8({1, 2, 3, 1});
    return Bytes().add(body).take();
}

Descriptor configuration_descriptor() {
    Bytes all;
    all.add(Bytes().u8({configuration}).u16(0).u8({2, 1, 0, 0x80, 250}));
    all.add(Bytes().u8({association, 0, 2, video_class, video_function, 0, 2}));
    add_control_interface(all);
    add_streaming_interface(all);
    all.set_length(2, 0);
    return all.take();
}

Descriptor string_descriptor(int index, const std::string &serial) {
    if (index == 0)
        return Bytes().add(Bytes().u8({string}).u16(0x0409)).take();
    const std::string text = index == 1 ? "Afterglow" : index == 2 ? "Test Camera" : serial;
    Bytes body;
    body.u8({string});
    for (const char letter : text)
        body.u16(static_cast<std::uint8_t>(letter));
    return Bytes().add(body).take();
}

} // namespace afterglow::vm
