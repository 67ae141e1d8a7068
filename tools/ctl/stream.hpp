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
    /// Asks the daemon on the bus called `bus`.
    static Result<Stream> open(const std::string &bus);

    afterglow_stream_info info() const;
    /// Waits for the newest frame that has not been read and copies it out.
    Result<afterglow_frame> next(std::span<const afterglow_buffer> buffers = {});
    std::uint64_t skipped() const { return afterglow_skipped(stream_.get()); }

private:
    struct Closer {
        void operator()(afterglow_stream *stream) const { afterglow_close(stream); }
    };
    Stream(afterglow_stream *stream, std::int64_t opened_ns)
        : stream_(stream), opened_ns_(opened_ns) {}

    std::unique_ptr<afterglow_stream, Closer> stream_;
    std::int64_t opened_ns_; ///< what the ring holds from before may be hours old
};

} // namespace afterglow
