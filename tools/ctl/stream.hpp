// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "afterglow/afterglow.h"
#include "core/base/result.hpp"

#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <string>

namespace afterglow {

/// A stream of the daemon's frames, from the moment it was opened on.
class Stream {
public:
    /// What is asked for: not everybody who may read depth may see images.
    enum class Planes { depth, images };

    /// Asks the daemon on the bus called `bus`. Errors as those of Daemon.
    static Result<Stream> open(const std::string &bus, Planes planes);

    struct Size {
        int width;
        int height;
    };
    /// Of a plane, pixels: images may have another size than depth. 0 x 0: there is no such plane.
    Size size(afterglow_plane_kind plane) const;
    /// Waits for the newest frame that has not been read and copies it out.
    Result<afterglow_frame> next(std::span<const afterglow_buffer> buffers = {});
    std::uint64_t skipped() const { return afterglow_skipped(stream_.get()); }

private:
    struct Closer {
        void operator()(afterglow_stream *stream) const { afterglow_close(stream); }
    };
    explicit Stream(afterglow_stream *stream) : stream_(stream) {}

    std::unique_ptr<afterglow_stream, Closer> stream_;
};

/// Nanoseconds from the capture of a frame's image to `then_ns` (CLOCK_MONOTONIC). Nothing where
/// its time is that of a recording, which says nothing of now (replay.real_time = false).
inline std::optional<std::int64_t> since_capture_ns(const afterglow_frame &frame,
                                                    std::int64_t then_ns) {
    constexpr std::int64_t hour_ns = 3'600'000'000'000;
    const std::int64_t since_ns = then_ns - frame.t_ns;
    return since_ns >= 0 && since_ns < hour_ns ? std::optional(since_ns) : std::nullopt;
}

} // namespace afterglow
