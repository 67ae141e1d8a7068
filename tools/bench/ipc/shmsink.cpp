// SPDX-License-Identifier: Apache-2.0
//
// GStreamer: appsrc ! shmsink, shmsrc ! appsink. Frames are taken in the thread that shmsrc reads
// its socket in.
#include "tools/bench/ipc/transport.hpp"

#include <fmt/format.h>

#include <cerrno>
#include <gst/app/gstappsink.h>
#include <gst/app/gstappsrc.h>
#include <gst/gst.h>
#include <poll.h>
#include <unistd.h>

namespace afterglow::bench {
namespace {

struct Unref {
    void operator()(gpointer object) const { gst_object_unref(object); }
};
template <class T>
using Owner = std::unique_ptr<T, Unref>;
using Element = Owner<GstElement>;

std::string socket_path(const Session &session) {
    return session.folder + "/shm";
}

Result<Element> launch(const std::string &description) {
    gst_init(nullptr, nullptr);
    GError *error = nullptr;
    Element pipeline(gst_parse_launch(description.c_str(), &error));
    if (error != nullptr) {
        Error problem{error->message, EINVAL};
        g_error_free(error);
        return problem;
    }
    return pipeline;
}

Element named(const Element &pipeline, const char *name) {
    return Element(gst_bin_get_by_name(GST_BIN(pipeline.get()), name));
}

class ShmsinkPublisher : public Publisher {
public:
    explicit ShmsinkPublisher(Element pipeline)
        : pipeline_(std::move(pipeline)), source_(named(pipeline_, "source")) {}
    ~ShmsinkPublisher() override { gst_element_set_state(pipeline_.get(), GST_STATE_NULL); }

    void publish(std::span<const std::byte> frame) override {
        // The memory stays ours; shmsink copies it.
        auto *data = const_cast<std::byte *>(frame.data());
        GstBuffer *buffer = gst_buffer_new_wrapped_full(
            GST_MEMORY_FLAG_READONLY, data, frame.size(), 0, frame.size(), nullptr, nullptr);
        gst_app_src_push_buffer(GST_APP_SRC(source_.get()), buffer);
    }

private:
    Element pipeline_;
    Element source_;
};

Result<std::unique_ptr<Publisher>> publisher(const Session &session, int /*readers*/) {
    Result<Element> pipeline =
        launch(fmt::format("appsrc name=source is-live=true format=time ! shmsink socket-path={} "
                           "shm-size={} wait-for-connection=false sync=false async=false",
                           socket_path(session), 16 * frame_bytes));
    if (!pipeline)
        return pipeline.error();
    if (gst_element_set_state(pipeline->get(), GST_STATE_PLAYING) == GST_STATE_CHANGE_FAILURE)
        return Error{"shmsink does not start", EIO};
    return std::unique_ptr<Publisher>(new ShmsinkPublisher(*std::move(pipeline)));
}

GstFlowReturn on_sample(GstAppSink *sink, gpointer context) {
    GstSample *sample = gst_app_sink_pull_sample(sink);
    if (sample == nullptr)
        return GST_FLOW_EOS;
    GstBuffer *buffer = gst_sample_get_buffer(sample);
    GstMapInfo map;
    if (gst_buffer_map(buffer, &map, GST_MAP_READ) != 0) {
        if (map.size == frame_bytes) {
            const auto *frame = reinterpret_cast<const std::byte *>(map.data);
            (*static_cast<const OnFrame *>(context))(frame, frame + depth_bytes);
        }
        gst_buffer_unmap(buffer, &map);
    }
    gst_sample_unref(sample);
    return GST_FLOW_OK;
}

Error receive(const Session &session, int /*reader*/, const OnFrame &on_frame) {
    while (access(socket_path(session).c_str(), F_OK) != 0)
        poll(nullptr, 0, 5);
    const Result<Element> pipeline = launch(fmt::format(
        "shmsrc socket-path={} is-live=true ! appsink name=sink sync=false", socket_path(session)));
    if (!pipeline)
        return pipeline.error();
    const Element sink = named(*pipeline, "sink");
    GstAppSinkCallbacks callbacks{};
    callbacks.new_sample = on_sample;
    gst_app_sink_set_callbacks(GST_APP_SINK(sink.get()), &callbacks,
                               const_cast<OnFrame *>(&on_frame), nullptr);
    gst_element_set_state(pipeline->get(), GST_STATE_PLAYING);
    const Owner<GstBus> bus(gst_element_get_bus(pipeline->get()));
    gst_message_unref(gst_bus_timed_pop_filtered(
        bus.get(), GST_CLOCK_TIME_NONE,
        static_cast<GstMessageType>(GST_MESSAGE_ERROR | GST_MESSAGE_EOS)));
    gst_element_set_state(pipeline->get(), GST_STATE_NULL);
    return {"shmsrc has ended", EPIPE};
}

} // namespace

const Transport shmsink_transport = {"shmsink", publisher, receive};

} // namespace afterglow::bench
