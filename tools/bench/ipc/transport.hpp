// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "core/base/result.hpp"
#include "core/base/unique_fd.hpp"

#include <array>
#include <atomic>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <memory>
#include <span>
#include <string>
#include <string_view>

namespace afterglow::bench {

// What all transports carry: a depth map of VGA size, and after it its confidence.
inline constexpr int width = 640;
inline constexpr int height = 480;
inline constexpr std::size_t depth_bytes = std::size_t{2} * width * height;
inline constexpr std::size_t confidence_bytes = std::size_t{1} * width * height;
inline constexpr std::size_t frame_bytes = depth_bytes + confidence_bytes;
inline constexpr int frames_per_second = 60;

/// In place of the first pixels of each depth map.
struct Stamp {
    std::int64_t published_ns; ///< CLOCK_MONOTONIC, when publish() was called
    std::uint64_t index;
};

/// What the processes of a case share.
struct Session {
    static constexpr std::size_t most_readers = 8;

    std::string folder; ///< for sockets
    /// To each reader a socket pair: the publisher has the first end, the reader the second.
    std::array<std::array<UniqueFd, 2>, most_readers> sockets;
    std::atomic<std::uint32_t> *pipewire_node = nullptr; ///< the publisher's; 0: not there yet
};

/// Gives frames to others. One thread.
class Publisher {
public:
    virtual ~Publisher() = default;
    /// `frame` has frame_bytes and stays as it is until the next call has returned.
    virtual void publish(std::span<const std::byte> frame) = 0;
};

/// Called for each frame as soon as it can be read, in whichever thread it came to.
using OnFrame = std::function<void(const std::byte *depth, const std::byte *confidence)>;

/// A way to bring frames to other processes. All but the name runs in processes of its own, which
/// end by being killed.
struct Transport {
    std::string_view name;
    Result<std::unique_ptr<Publisher>> (*publisher)(const Session &session, int readers);
    /// Takes frames until it cannot any more, and says why.
    Error (*receive)(const Session &session, int reader, const OnFrame &on_frame);
};

extern const Transport afterglow_transport;
extern const Transport shmsink_transport;  ///< GStreamer's
extern const Transport pipewire_transport; ///< needs a PipeWire daemon at $PIPEWIRE_RUNTIME_DIR

} // namespace afterglow::bench
