// SPDX-License-Identifier: Apache-2.0
#include "tools/bench/ipc/pipewire_stream.hpp"

#include "tools/bench/ipc/transport.hpp"

#include <cerrno>
#include <spa/param/video/format-utils.h>

namespace afterglow::bench {
namespace {

constexpr std::uint32_t rows = frame_bytes / width; // of grey bytes

const spa_pod *format(spa_pod_builder &builder) {
    spa_video_info_raw info{};
    info.format = SPA_VIDEO_FORMAT_GRAY8;
    info.size = {width, rows};
    info.framerate = {frames_per_second, 1};
    return spa_format_video_raw_build(&builder, SPA_PARAM_EnumFormat, &info);
}

} // namespace

void ask_for_buffers(pw_stream *stream, std::uint32_t parameter, const spa_pod *value) {
    if (parameter != SPA_PARAM_Format || value == nullptr)
        return;
    std::uint8_t memory[512];
    spa_pod_builder builder = SPA_POD_BUILDER_INIT(memory, sizeof memory);
    const auto *buffers = static_cast<const spa_pod *>(spa_pod_builder_add_object(
        &builder, SPA_TYPE_OBJECT_ParamBuffers, SPA_PARAM_Buffers, //
        SPA_PARAM_BUFFERS_buffers, SPA_POD_CHOICE_RANGE_Int(8, 2, 16), SPA_PARAM_BUFFERS_blocks,
        SPA_POD_Int(1), SPA_PARAM_BUFFERS_size, SPA_POD_Int(static_cast<int>(frame_bytes)),
        SPA_PARAM_BUFFERS_stride, SPA_POD_Int(width)));
    pw_stream_update_params(stream, &buffers, 1);
}

Result<std::unique_ptr<PipewireStream>> PipewireStream::open(pw_direction direction,
                                                             pw_stream_flags flags,
                                                             const pw_stream_events &events,
                                                             void *context) {
    pw_init(nullptr, nullptr);
    auto opened = std::make_unique<PipewireStream>();
    opened->loop.reset(pw_thread_loop_new("bench", nullptr));
    opened->context.reset(pw_context_new(pw_thread_loop_get_loop(opened->loop.get()), nullptr, 0));
    opened->core = pw_context_connect(opened->context.get(), nullptr, 0);
    if (opened->core == nullptr)
        return Error{"no PipeWire daemon answers", errno};
    opened->stream.reset(pw_stream_new(
        opened->core, "afterglow-bench",
        pw_properties_new(PW_KEY_MEDIA_CLASS,
                          direction == PW_DIRECTION_OUTPUT ? "Video/Source" : "Stream/Input/Video",
                          nullptr)));
    pw_stream_add_listener(opened->stream.get(), &opened->listener, &events, context);
    std::uint8_t memory[512];
    spa_pod_builder builder = SPA_POD_BUILDER_INIT(memory, sizeof memory);
    const spa_pod *offered = format(builder);
    const auto all = static_cast<pw_stream_flags>(flags | PW_STREAM_FLAG_MAP_BUFFERS |
                                                  PW_STREAM_FLAG_RT_PROCESS);
    if (const int error =
            pw_stream_connect(opened->stream.get(), direction, PW_ID_ANY, all, &offered, 1);
        error < 0)
        return Error{"PipeWire refuses the stream", -error};
    if (const int error = pw_thread_loop_start(opened->loop.get()); error < 0)
        return Error{"PipeWire's loop does not start", -error};
    return opened;
}

PipewireStream::~PipewireStream() {
    if (loop)
        pw_thread_loop_stop(loop.get());
}

} // namespace afterglow::bench
