// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "afterglow/afterglow.h"
#include "core/base/child_process.hpp"
#include "core/base/result.hpp"

#include <memory>
#include <string>

namespace afterglow {

/// A daemon with a bus of its own, and a stream from it: everything a user of afterglow has, on a
/// machine where nothing is installed.
class LiveSession {
public:
    /// Starts dbus-daemon and the afterglowd that lies beside this program, with `config` as its
    /// configuration file, and opens a stream. Leaves no file behind.
    static Result<LiveSession> start(const std::string &config);

    afterglow_stream *stream() { return stream_.get(); }
    /// After the stream's end: whether the daemon left because the recording is over.
    Status end();

private:
    struct CloseStream {
        void operator()(afterglow_stream *stream) const { afterglow_close(stream); }
    };
    using Stream = std::unique_ptr<afterglow_stream, CloseStream>;
    LiveSession(ChildProcess bus, ChildProcess daemon, Stream stream)
        : bus_(std::move(bus)), daemon_(std::move(daemon)), stream_(std::move(stream)) {}

    // In this order, so that they end in the opposite one.
    ChildProcess bus_;
    ChildProcess daemon_;
    Stream stream_;
};

} // namespace afterglow
