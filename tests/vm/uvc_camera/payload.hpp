// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "tests/vm/uvc_camera/controls.hpp"

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

namespace afterglow::vm {

/// What goes wrong with the camera, on command. Counts are used up.
struct Faults {
    int bad_frames = 0;     ///< the camera sets the error bit of their payloads
    int short_frames = 0;   ///< half of the frame is sent
    int dropped_frames = 0; ///< not sent, while the camera's count goes on
    int lost_packets = 0;   ///< the bus fails (EPROTO)
    bool frozen = false;    ///< nothing is sent
    std::int64_t stalled_until_ns = 0;
};

/// Cuts the images of a test pattern (test_pattern.hpp) into the packets of a UVC stream.
class PayloadStream {
public:
    Faults faults;

    /// Begins anew; the count of images goes on, as a sensor's does.
    void start(const StreamChoice &choice);
    /// Writes what the camera sends in the packet at time `t_ns`; returns how many bytes, 0 where
    /// it sends nothing.
    std::size_t fill(std::span<std::uint8_t> packet, std::int64_t t_ns);

private:
    bool begin_frame(std::int64_t t_ns);
    void draw();

    StreamChoice choice_;
    std::vector<std::uint8_t> frame_;
    std::size_t sent_ = 0;
    std::size_t size_ = 0; ///< bytes of this frame that will be sent; 0 = between frames
    bool bad_ = false;
    std::uint8_t toggle_ = 0;
    std::uint32_t index_ = 0;
    std::int64_t next_ns_ = 0;
};

} // namespace afterglow::vm
