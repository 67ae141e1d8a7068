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
    static Result<Stream> open(const std::string &bus, bool images = false);

    afterglow_info info() const;
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
