// SPDX-License-Identifier: Apache-2.0
//
// PipeWire: a video source that drives the graph, and streams that are linked to it without a
// session manager: each reader makes its link itself.
#include "tools/bench/ipc/pipewire_stream.hpp"
#include "tools/bench/ipc/transport.hpp"

#include <cstdlib>
#include <cstring>
#include <poll.h>

namespace afterglow::bench {
namespace {

class PipewirePublisher : public Publisher {
public:
    static Result<std::unique_ptr<Publisher>> create(const Session &session, int /*readers*/) {
        std::unique_ptr<PipewirePublisher> publisher(new PipewirePublisher(session.pipewire_node));
        auto stream = PipewireStream::open(PW_DIRECTION_OUTPUT, PW_STREAM_FLAG_DRIVER, events,
                                           publisher.get());
        if (!stream)
            return stream.error();
        publisher->stream_ = *std::move(stream);
        return std::unique_ptr<Publisher>(std::move(publisher));
    }

    void publish(std::span<const std::byte> frame) override {
        pw_thread_loop_lock(stream_->loop.get());
        pw_stream *stream = stream_->stream.get();
        const std::uint32_t node = pw_stream_get_node_id(stream);
        node_->store(node == SPA_ID_INVALID ? 0 : node);
        if (pw_stream_get_state(stream, nullptr) == PW_STREAM_STATE_STREAMING) {
            frame_.store(frame.data());
            pw_stream_trigger_process(stream);
        }
        pw_thread_loop_unlock(stream_->loop.get());
    }

private:
    explicit PipewirePublisher(std::atomic<std::uint32_t> *node) : node_(node) {}

    static void on_parameter(void *self, std::uint32_t id, const spa_pod *value) {
        ask_for_buffers(static_cast<PipewirePublisher *>(self)->stream_->stream.get(), id, value);
    }
    static void on_process(void *self) {
        auto *publisher = static_cast<PipewirePublisher *>(self);
        pw_stream *stream = publisher->stream_->stream.get();
        const std::byte *frame = publisher->frame_.exchange(nullptr);
        pw_buffer *buffer = frame != nullptr ? pw_stream_dequeue_buffer(stream) : nullptr;
        if (buffer == nullptr)
            return;
        spa_data &data = buffer->buffer->datas[0];
        std::memcpy(data.data, frame, frame_bytes);
        data.chunk->offset = 0;
        data.chunk->size = frame_bytes;
        data.chunk->stride = width;
        pw_stream_queue_buffer(stream, buffer);
    }
    static constexpr pw_stream_events events = {
        .version = PW_VERSION_STREAM_EVENTS, .param_changed = on_parameter, .process = on_process};

    std::unique_ptr<PipewireStream> stream_;
    std::atomic<std::uint32_t> *node_;
    std::atomic<const std::byte *> frame_ = nullptr; ///< for the data thread
};

/// Takes frames in the data thread; links itself in the loop's.
class PipewireReceiver {
public:
    PipewireReceiver(const Session &session, const OnFrame &on_frame)
        : source_(session.pipewire_node), on_frame_(on_frame) {}

    Error run() {
        while (source_->load() == 0)
            poll(nullptr, 0, 5);
        auto stream =
            PipewireStream::open(PW_DIRECTION_INPUT, PW_STREAM_FLAG_NONE, stream_events, this);
        if (!stream)
            return stream.error();
        stream_ = *std::move(stream);
        pw_thread_loop *loop = stream_->loop.get();
        pw_thread_loop_lock(loop);
        while (pw_stream_get_node_id(stream_->stream.get()) == SPA_ID_INVALID)
            pw_thread_loop_timed_wait(loop, 1);
        pw_registry *registry = pw_core_get_registry(stream_->core, PW_VERSION_REGISTRY, 0);
        pw_registry_add_listener(registry, &registry_listener_, &registry_events, this);
        while (!failed_)
            pw_thread_loop_wait(loop);
        pw_thread_loop_unlock(loop);
        return {"the PipeWire stream has ended", EPIPE};
    }

private:
    static void on_process(void *self) {
        auto *receiver = static_cast<PipewireReceiver *>(self);
        pw_stream *stream = receiver->stream_->stream.get();
        pw_buffer *buffer = pw_stream_dequeue_buffer(stream);
        if (buffer == nullptr)
            return;
        const spa_data &data = buffer->buffer->datas[0];
        if (data.chunk->size == frame_bytes) {
            const auto *frame = static_cast<const std::byte *>(data.data) + data.chunk->offset;
            receiver->on_frame_(frame, frame + depth_bytes);
        }
        pw_stream_queue_buffer(stream, buffer);
    }
    static void on_state(void *self, pw_stream_state /*before*/, pw_stream_state now,
                         const char * /*problem*/) {
        auto *receiver = static_cast<PipewireReceiver *>(self);
        if (now != PW_STREAM_STATE_ERROR && now != PW_STREAM_STATE_UNCONNECTED)
            return;
        receiver->failed_ = true;
        pw_thread_loop_signal(receiver->stream_->loop.get(), false);
    }
    /// Finds the two ports to link.
    static void on_global(void *self, std::uint32_t id, std::uint32_t /*permissions*/,
                          const char *type, std::uint32_t /*version*/, const spa_dict *properties) {
        auto *receiver = static_cast<PipewireReceiver *>(self);
        const char *node =
            properties != nullptr ? spa_dict_lookup(properties, PW_KEY_NODE_ID) : nullptr;
        if (node == nullptr || std::strcmp(type, PW_TYPE_INTERFACE_Port) != 0)
            return;
        const auto of_node = static_cast<std::uint32_t>(std::strtoul(node, nullptr, 10));
        if (of_node == receiver->source_->load())
            receiver->output_port_ = id;
        else if (of_node == pw_stream_get_node_id(receiver->stream_->stream.get()))
            receiver->input_port_ = id;
        else
            return;
        if (receiver->output_port_ != SPA_ID_INVALID && receiver->input_port_ != SPA_ID_INVALID)
            receiver->link();
    }
    void link() {
        pw_properties *ports = pw_properties_new(nullptr, nullptr);
        pw_properties_setf(ports, PW_KEY_LINK_OUTPUT_NODE, "%u", source_->load());
        pw_properties_setf(ports, PW_KEY_LINK_OUTPUT_PORT, "%u", output_port_);
        pw_properties_setf(ports, PW_KEY_LINK_INPUT_NODE, "%u",
                           pw_stream_get_node_id(stream_->stream.get()));
        pw_properties_setf(ports, PW_KEY_LINK_INPUT_PORT, "%u", input_port_);
        pw_core_create_object(stream_->core, "link-factory", PW_TYPE_INTERFACE_Link,
                              PW_VERSION_LINK, &ports->dict, 0);
        pw_properties_free(ports);
    }
    static constexpr pw_stream_events stream_events = {
        .version = PW_VERSION_STREAM_EVENTS, .state_changed = on_state, .process = on_process};
    static constexpr pw_registry_events registry_events = {.version = PW_VERSION_REGISTRY_EVENTS,
                                                           .global = on_global};

    std::atomic<std::uint32_t> *source_;
    const OnFrame &on_frame_;
    std::unique_ptr<PipewireStream> stream_;
    spa_hook registry_listener_{};
    std::uint32_t output_port_ = SPA_ID_INVALID;
    std::uint32_t input_port_ = SPA_ID_INVALID;
    bool failed_ = false;
};

Error receive(const Session &session, int /*reader*/, const OnFrame &on_frame) {
    return PipewireReceiver(session, on_frame).run();
}

} // namespace

const Transport pipewire_transport = {"pipewire", PipewirePublisher::create, receive};

} // namespace afterglow::bench
