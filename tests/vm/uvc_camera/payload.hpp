// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "core/base/image.hpp"
#include "drivers/simulated/rounds.hpp"
#include "tests/vm/uvc_camera/controls.hpp"

#include <cstddef>
#include <cstdint>
#include <memory>
#include <span>
#include <utility>
#include <vector>

namespace afterglow::vm {

/// What goes wrong with the camera, on command. Counts are used up.
struct Faults {
    int bad_frames = 0;     ///< the camera sets the error bit of their payloads
    int short_frames = 0;   ///< half of the frame is sent
    int dropped_frames = 0; ///< not sent, while the camera's count goes on
    int lost_packets = 0;   ///< the bus fails (EPROTO)
    bool frozen = false;    ///< nothing is sent
    bool cut = false;       ///< the camera goes in the middle of a frame
    std::int64_t stalled_until_ns = 0;
};

/// Images, or depth maps, to send in place of a test pattern, of one of the camera's sizes.
class ImageSequence {
public:
    virtual ~ImageSequence() = default;
    /// The first image that is due after `t_ns`, CLOCK_MONOTONIC.
    virtual Rounds::Frame next(std::int64_t t_ns) const = 0;
    virtual std::uint16_t pixel(std::uint64_t number, int u, int v) const = 0;
};

/// Cuts the images of a test pattern (test_pattern.hpp), or of a sequence, into the packets of a
/// UVC stream.
class PayloadStream {
public:
    Faults faults;

    explicit PayloadStream(std::unique_ptr<ImageSequence> sequence)
        : sequence_(std::move(sequence)) {}
    /// Begins anew; the count of images goes on, as a sensor's does.
    void start(const StreamChoice &choice);
    /// Writes what the camera sends in the packet at time `t_ns`; returns how many bytes, 0 where
    /// it sends nothing.
    std::size_t fill(std::span<std::uint8_t> packet, std::int64_t t_ns);
    /// Half of a frame was sent, and no more is to come.
    bool is_cut() const { return faults.cut && size_ > 0 && 2 * sent_ >= size_; }

private:
    bool begin_frame(std::int64_t t_ns);
    void begin_interval(std::int64_t t_ns);
    /// As a little-endian word of the image that is drawn; of luma the upper half is what stands
    /// beside it.
    std::uint16_t pixel(int u, int v) const;
    /// Draws the next image.
    void draw();

    std::unique_ptr<ImageSequence> sequence_; ///< or none
    std::uint64_t image_ = 0;                 ///< that is next
    StreamChoice choice_;
    std::vector<std::uint8_t> frame_; ///< being sent, and then the next
    bool drawn_ = false;              ///< the next
    std::size_t sent_ = 0;
    std::size_t size_ = 0; ///< bytes of this frame that will be sent; 0 = between frames
    bool bad_ = false;
    std::uint8_t toggle_ = 0;
    std::uint32_t index_ = 0;
    std::int64_t next_ns_ = 0;
};

} // namespace afterglow::vm
