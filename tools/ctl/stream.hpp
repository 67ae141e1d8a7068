// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "afterglow/afterglow.h"
#include "core/base/result.hpp"

#include <cstdint>
#include <memory>
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

} // namespace afterglow
