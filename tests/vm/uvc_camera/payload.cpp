// SPDX-License-Identifier: Apache-2.0
#include "tests/vm/uvc_camera/payload.hpp"

#include "tests/vm/test_pattern.hpp"
#include "tests/vm/uvc_camera/descriptors.hpp"

#include <algorithm>
#include <utility>

namespace afterglow::vm {
namespace {

// The payload header's bits (USB Video Class 1.0, section 2.4.3.3).
enum : std::uint8_t { end_of_frame = 0x02, error = 0x40, end_of_header = 0x80 };
constexpr std::size_t header_bytes = 2;

constexpr std::int64_t long_pause_ns = 1'000'000'000;

} // namespace

void PayloadStream::start(const StreamChoice &choice) {
    choice_ = choice;
    size_ = 0;
    toggle_ = 0;
    next_ns_ = 0;
}

std::size_t PayloadStream::fill(std::span<std::uint8_t> packet, std::int64_t t_ns) {
    if (packet.size() <= header_bytes)
        return 0;
    if (faults.frozen || t_ns < faults.stalled_until_ns) {
        size_ = 0;
        return 0;
    }
    if (size_ == 0 && !begin_frame(t_ns))
        return 0;
    if (is_cut())
        return 0;
    const std::size_t bytes = std::min(packet.size() - header_bytes, size_ - sent_);
    packet[0] = header_bytes;
    packet[1] = end_of_header | toggle_ | (bad_ ? error : 0);
    std::copy_n(frame_.begin() + static_cast<std::ptrdiff_t>(sent_), bytes,
                packet.begin() + header_bytes);
    sent_ += bytes;
    if (sent_ == size_) {
        packet[1] |= end_of_frame;
        size_ = 0;
    }
    return header_bytes + bytes;
}

bool PayloadStream::begin_frame(std::int64_t t_ns) {
    if (next_ns_ == 0 || t_ns > next_ns_ + long_pause_ns)
        begin_interval(sequence_ ? t_ns : t_ns - std::int64_t{choice_.interval} * 100);
    // Drawn ahead, as it takes the emulated processor many milliseconds.
    if (!std::exchange(drawn_, true))
        draw();
    if (t_ns < next_ns_)
        return false;
    ++index_;
    begin_interval(next_ns_);
    if (faults.dropped_frames > 0) {
        --faults.dropped_frames;
        return false;
    }
    sent_ = 0;
    size_ = frame_.size();
    toggle_ ^= 1;
    if (faults.short_frames > 0) {
        --faults.short_frames;
        size_ /= 2;
    }
    bad_ = faults.bad_frames > 0;
    faults.bad_frames -= bad_ ? 1 : 0;
    return true;
}

/// When the next image is due, after one at `t_ns`.
void PayloadStream::begin_interval(std::int64_t t_ns) {
    next_ns_ = t_ns + std::int64_t{choice_.interval} * 100;
    drawn_ = false;
    if (sequence_) {
        const Rounds::Frame frame = sequence_->next(t_ns);
        next_ns_ = frame.due_ns;
        image_ = frame.number;
    }
}

std::uint16_t PayloadStream::pixel(int u, int v) const {
    constexpr unsigned beside = other_byte << 8;
    if (!sequence_)
        return static_cast<std::uint16_t>(beside | pattern(index_ + 1, v));
    const std::uint16_t pixel = sequence_->pixel(image_, u, v);
    return uvc_formats[choice_.format].is_depth ? pixel
                                                : static_cast<std::uint16_t>(beside | pixel);
}

void PayloadStream::draw() {
    const UvcSize &size = uvc_sizes[choice_.size];
    const std::size_t step = uvc_formats[choice_.format].bytes_per_pixel;
    frame_.resize(step * size.width * size.height);
    auto byte = frame_.begin();
    for (int v = 0; v < size.height; ++v) {
        for (int u = 0; u < size.width; ++u) {
            const std::uint16_t word = pixel(u, v);
            *byte++ = static_cast<std::uint8_t>(word);
            if (step == 2)
                *byte++ = static_cast<std::uint8_t>(word >> 8);
        }
    }
}

} // namespace afterglow::vm
