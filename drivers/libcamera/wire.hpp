// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "core/base/unique_fd.hpp"

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <string_view>
#include <vector>

namespace afterglow::libcam {

// The messages between afterglowd and afterglow-libcamera, over a pair of SOCK_SEQPACKET sockets.
//
//     helper ─▶ (camera mode*)* done | failed           asked to list
//     helper ─▶ streaming (frame | damaged)* failed     asked to capture
//     daemon ─▶ the number of a frame's buffer, which may be filled again
//
// The images stay in libcamera's buffers, whose descriptors are sent with `streaming`. There are at
// most as many messages in flight as buffers, so the socket serves as a bounded queue.

inline constexpr std::size_t max_buffers = 8;
/// The helper's end of the connection.
inline constexpr int helper_socket = 3;

struct Report {
    enum class Kind : std::uint8_t { camera, mode, done, streaming, frame, damaged, failed };
    /// The position of a buffer's first plane within its descriptor's memory; bytes.
    struct BufferPlane {
        std::uint32_t offset = 0;
        std::uint32_t length = 0;
    };

    Kind kind = Kind::failed;
    bool begins_exposure = false; ///< stamp_ns is of the exposure's begin; otherwise its end
    std::int32_t code = 0;        ///< failed: the errno, or 0
    std::uint32_t fourcc = 0;     ///< mode, streaming: of V4L2
    std::int32_t width = 0;
    std::int32_t height = 0;
    std::uint32_t stride = 0;
    std::uint32_t buffer = 0;   ///< frame: its number; streaming: how many there are
    std::uint32_t bytes = 0;    ///< frame: in the first plane
    std::uint32_t sequence = 0; ///< frame, damaged: the camera's count
    std::int64_t stamp_ns = 0;
    std::int64_t arrival_ns = 0; ///< CLOCK_MONOTONIC in the helper
    std::array<BufferPlane, max_buffers> planes{};
    /// failed: a sentence; camera: its id, a line break, its model. Ends in a zero.
    std::array<char, 1024> text{};

    void set_text(std::string_view words);
};

/// Waits while the queue of the socket is full. False if the other side has closed it.
bool send(int socket, const Report &report, std::span<const int> descriptors = {});

enum class Received { message, nothing, end };
/// Receives without waiting. A message that is not a whole Report counts as the end.
Received receive(int socket, Report &report, std::vector<UniqueFd> &descriptors);

} // namespace afterglow::libcam
