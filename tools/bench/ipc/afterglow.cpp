// SPDX-License-Identifier: Apache-2.0
//
// The daemon's ring, notifier and library: the publisher's thread is in the estimator thread's
// place, and another one in the main thread's.
#include "afterglow/afterglow.h"

#include "core/base/passed_fds.hpp"
#include "ipc/ring/ring_writer.hpp"
#include "ipc/ring/stream_notifier.hpp"
#include "tools/bench/ipc/transport.hpp"

#include <sys/socket.h>

#include <cerrno>
#include <poll.h>
#include <thread>
#include <utility>

namespace afterglow::bench {
namespace {

Status send_descriptor(int socket, int descriptor) {
    char byte = 0;
    iovec data = {&byte, 1};
    PassedFds<1> passed;
    msghdr message = {};
    message.msg_iov = &data;
    message.msg_iovlen = 1;
    passed.attach(message, {&descriptor, 1});
    if (sendmsg(socket, &message, MSG_NOSIGNAL) != 1)
        return Error{"a stream could not be handed over", errno};
    return ok();
}

/// Holds nothing if none came.
UniqueFd receive_descriptor(int socket) {
    char byte = 0;
    iovec data = {&byte, 1};
    PassedFds<1> passed;
    msghdr message = {};
    message.msg_iov = &data;
    message.msg_iovlen = 1;
    passed.make_room(message);
    UniqueFd received;
    if (recvmsg(socket, &message, MSG_CMSG_CLOEXEC) == 1)
        passed.take(message, [&](UniqueFd fd) { received = std::move(fd); });
    return received;
}

class RingPublisher : public Publisher {
public:
    static Result<std::unique_ptr<Publisher>> create(const Session &session, int readers) {
        auto writer = RingWriter::create({500, 500, 320, 240, width, height});
        if (!writer)
            return writer.error();
        auto notifier = StreamNotifier::create(**writer);
        if (!notifier)
            return notifier.error();
        for (std::size_t i = 0; i < static_cast<std::size_t>(readers); ++i) {
            const Result<UniqueFd> stream = (*notifier)->open(0, {});
            if (!stream)
                return stream.error();
            if (Status sent = send_descriptor(session.sockets[i][0].get(), stream->get()); !sent)
                return sent.error();
        }
        return std::unique_ptr<Publisher>(
            new RingPublisher(*std::move(writer), *std::move(notifier)));
    }

    void publish(std::span<const std::byte> frame) override {
        const auto *pixels = reinterpret_cast<const std::uint8_t *>(frame.data());
        Estimate estimate;
        estimate.source = FrameSource::estimated;
        estimate.depth = {reinterpret_cast<const std::uint16_t *>(pixels), width, height};
        estimate.confidence = {pixels + depth_bytes, width, height};
        afterglow_frame known{};
        known.fx = known.fy = 500;
        writer_->publish(estimate, {}, known);
        notifier_->frame_published();
    }

private:
    RingPublisher(std::unique_ptr<RingWriter> writer, std::unique_ptr<StreamNotifier> notifier)
        : writer_(std::move(writer)), notifier_(std::move(notifier)), main_thread_([this] {
              for (;;) {
                  pollfd event = {notifier_->event_fd(), POLLIN, 0};
                  poll(&event, 1, -1);
                  static_cast<void>(notifier_->update()); // fails only to give new memory
              }
          }) {
        main_thread_.detach(); // it ends with the process
    }

    std::unique_ptr<RingWriter> writer_;
    std::unique_ptr<StreamNotifier> notifier_;
    std::thread main_thread_;
};

Error receive(const Session &session, int reader, const OnFrame &on_frame) {
    const auto failed = [](int error) { return Error{afterglow_strerror(error), -error}; };
    UniqueFd socket =
        receive_descriptor(session.sockets[static_cast<std::size_t>(reader)][1].get());
    afterglow_stream *stream = nullptr;
    if (const int error = afterglow_open_fd(socket.release(), &stream); error < 0)
        return failed(error);
    for (;;) {
        afterglow_view views[2] = {{AFTERGLOW_PLANE_DEPTH, 0, nullptr},
                                   {AFTERGLOW_PLANE_CONFIDENCE, 0, nullptr}};
        if (const int error = afterglow_wait(stream, -1); error < 0)
            return failed(error);
        const int error = afterglow_peek(stream, nullptr, views, 2);
        if (error < 0 && error != -EAGAIN)
            return failed(error);
        if (error == 0)
            on_frame(static_cast<const std::byte *>(views[0].data),
                     static_cast<const std::byte *>(views[1].data));
    }
}

} // namespace

const Transport afterglow_transport = {"afterglow", RingPublisher::create, receive};

} // namespace afterglow::bench
