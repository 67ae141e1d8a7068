// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "core/base/result.hpp"

#include <memory>
#include <pipewire/pipewire.h>

namespace afterglow::bench {

template <auto destroy>
struct PipewireDestroyer {
    void operator()(auto *object) const { destroy(object); }
};
template <class T, auto destroy>
using PipewireOwner = std::unique_ptr<T, PipewireDestroyer<destroy>>;

/// A video stream of the bench's frames in a thread loop, whose lock the callers of PipeWire's
/// functions take.
struct PipewireStream {
    /// Connects to the daemon. Of `events` the caller sets what it wants, with `context` as its
    /// data; process comes in PipeWire's data thread.
    static Result<std::unique_ptr<PipewireStream>> open(pw_direction direction,
                                                        pw_stream_flags flags,
                                                        const pw_stream_events &events,
                                                        void *context);
    ~PipewireStream();

    PipewireOwner<pw_thread_loop, pw_thread_loop_destroy> loop;
    PipewireOwner<pw_context, pw_context_destroy> context;
    pw_core *core = nullptr; // the context's
    PipewireOwner<pw_stream, pw_stream_destroy> stream;
    spa_hook listener{};
};

/// For pw_stream_events::param_changed: once the format is agreed on, asks for buffers of a frame.
void ask_for_buffers(pw_stream *stream, std::uint32_t parameter, const spa_pod *value);

} // namespace afterglow::bench
