// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "core/base/unique_fd.hpp"

namespace afterglow {

/// What came on a stream's socket.
struct StreamMessage {
    enum class Kind {
        nothing, ///< no datagram waits
        frame,   ///< a frame, or something this library does not know
        memory,  ///< the descriptors below
        end,     ///< the stream is over, because of `error`
    } kind = Kind::nothing;
    UniqueFd depth;
    UniqueFd images; ///< none where the stream has no images
    int error = 0;   ///< negative errno
};

/// Whether it can be a stream's: 0, -EPROTO or what asking for its type gave.
int check_stream_socket(const UniqueFd &socket);

/// Takes one datagram off the socket. Never blocks.
StreamMessage receive(const UniqueFd &socket);

} // namespace afterglow
