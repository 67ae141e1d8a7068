// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "afterglow/afterglow.h"
#include "ipc/ring/ring_writer.hpp"
#include "ipc/ring/stream_notifier.hpp"
#include "tests/catch.hpp"
#include "tests/open_stream.hpp"

#include <algorithm>
#include <cstdint>
#include <memory>
#include <utility>
#include <vector>

namespace afterglow::test {

struct StreamCloser {
    void operator()(afterglow_stream *stream) const { afterglow_close(stream); }
};
using Stream = std::unique_ptr<afterglow_stream, StreamCloser>;

/// A ring and its streams, with frames whose every pixel follows from the frame's index.
class TestRing {
public:
    explicit TestRing(int width = 64, int height = 48, int slots = 8, int workers = 1)
        : camera_{50, 51, 31.5, 23.5, width, height}, workers_(workers),
          writer_(std::move(*RingWriter::create(camera_, slots))),
          streams_(std::move(*StreamNotifier::create(*writer_))), depth_(width, height),
          confidence_(width, height), luma_(width, height) {}

    RingWriter &writer() { return *writer_; }
    StreamNotifier &streams() { return *streams_; }
    const Intrinsics &camera() const { return camera_; }

    static std::uint16_t depth_of(std::uint64_t index) {
        return static_cast<std::uint16_t>(index * 40503);
    }
    static std::uint8_t confidence_of(std::uint64_t index) {
        return static_cast<std::uint8_t>(index * 167);
    }
    static std::uint8_t luma_of(std::uint64_t index) {
        return static_cast<std::uint8_t>(index * 89 + 1);
    }

    /// Writes the next frame and tells nobody.
    afterglow_frame write() {
        const std::uint64_t index = writer_->head();
        std::fill(depth_.pixels().begin(), depth_.pixels().end(), depth_of(index));
        std::fill(confidence_.pixels().begin(), confidence_.pixels().end(), confidence_of(index));
        std::fill(luma_.pixels().begin(), luma_.pixels().end(), luma_of(index));
        Estimate estimate;
        estimate.source = FrameSource::estimated;
        estimate.age_frames = static_cast<std::uint32_t>(index);
        estimate.depth = depth_;
        estimate.confidence = confidence_.view();
        afterglow_frame frame{};
        frame.sequence = index;
        frame.calibration = 1;
        frame.fx = camera_.fx;
        frame.fy = camera_.fy;
        frame.cx = camera_.cx;
        frame.cy = camera_.cy;
        return writer_->publish(estimate, luma_, frame, &workers_);
    }
    afterglow_frame publish() {
        const afterglow_frame frame = write();
        streams_->frame_published();
        return frame;
    }

    /// A stream on this ring.
    Stream open(const StreamOptions &options = {.images = true}, uid_t user = 1) {
        Result<UniqueFd> socket = streams_->open(user, options);
        REQUIRE(socket);
        afterglow_stream *stream = nullptr;
        REQUIRE(afterglow_open_fd(socket->release(), &stream) == 0);
        return Stream(stream);
    }

private:
    Intrinsics camera_;
    WorkerPool workers_;
    std::unique_ptr<RingWriter> writer_;
    std::unique_ptr<StreamNotifier> streams_;
    DepthMap depth_;
    Image<std::uint8_t> confidence_;
    Luma luma_;
};

/// Buffers for all planes of a stream.
struct Planes {
    explicit Planes(const afterglow_stream *stream)
        : depth(afterglow_plane_bytes(stream, AFTERGLOW_PLANE_DEPTH) / 2),
          confidence(afterglow_plane_bytes(stream, AFTERGLOW_PLANE_CONFIDENCE)),
          luma(afterglow_plane_bytes(stream, AFTERGLOW_PLANE_LUMA)),
          wanted{{AFTERGLOW_PLANE_DEPTH, 0, depth.data(), depth.size() * 2},
                 {AFTERGLOW_PLANE_CONFIDENCE, 0, confidence.data(), confidence.size()},
                 {AFTERGLOW_PLANE_LUMA, 0, luma.data(), luma.size()}},
          count(luma.empty() ? 2 : 3) {}

    /// Whether every pixel is the one that frame `index` of a TestRing has.
    bool are_of(std::uint64_t index) const {
        const auto all = [](const auto &pixels, auto value) {
            return std::all_of(pixels.begin(), pixels.end(),
                               [&](auto pixel) { return pixel == value; });
        };
        return all(depth, TestRing::depth_of(index)) &&
               all(confidence, TestRing::confidence_of(index)) &&
               all(luma, TestRing::luma_of(index));
    }

    std::vector<std::uint16_t> depth;
    std::vector<std::uint8_t> confidence;
    std::vector<std::uint8_t> luma;
    afterglow_buffer wanted[3];
    std::size_t count; ///< of those, that the stream has
};

} // namespace afterglow::test
