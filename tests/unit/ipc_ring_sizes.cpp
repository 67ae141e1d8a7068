// SPDX-License-Identifier: Apache-2.0
//
// Two cameras: images of another size than depth, and the lens that depth is seen through.
#include "afterglow/afterglow.hpp"
#include "ipc/ring/stream_message.hpp"
#include "tests/test_ring.hpp"

#include <sys/socket.h>

#include <cerrno>
#include <chrono>
#include <limits>
#include <memory>
#include <optional>
#include <utility>
#include <vector>

using namespace afterglow;

namespace {

constexpr int depth_width = 37;
constexpr int depth_height = 21;
constexpr int image_width = 130;
constexpr int image_height = 75;

const Intrinsics depth_camera{30, 31, 18, 10, depth_width, depth_height};
const Intrinsics image_camera{90, 91, 64.5, 37, image_width, image_height};

/// A ring of two cameras, in which each pixel tells its place.
class TwoSizes {
public:
    TwoSizes()
        : writer_(std::move(*RingWriter::create(depth_camera, image_camera, 4))),
          streams_(std::move(*StreamNotifier::create(*writer_))), depth_(depth_width, depth_height),
          confidence_(depth_width, depth_height), luma_(image_width, image_height) {
        frame.calibration = 1;
        frame.fx = depth_camera.fx;
        frame.fy = depth_camera.fy;
        frame.cx = depth_camera.cx;
        frame.cy = depth_camera.cy;
        for (int v = 0; v < image_height; ++v)
            for (int u = 0; u < image_width; ++u)
                luma_(u, v) = luma_at(u, v);
        for (int v = 0; v < depth_height; ++v)
            for (int u = 0; u < depth_width; ++u) {
                depth_(u, v) = depth_at(u, v);
                confidence_(u, v) = confidence_at(u, v);
            }
    }

    static std::uint8_t luma_at(int u, int v) { return static_cast<std::uint8_t>(7 * u + 3 * v); }
    static std::uint16_t depth_at(int u, int v) {
        return static_cast<std::uint16_t>(1000 + 100 * v + u);
    }
    static std::uint8_t confidence_at(int u, int v) {
        return static_cast<std::uint8_t>(1 + 5 * u + v);
    }

    void publish() {
        Estimate estimate;
        estimate.source = FrameSource::measured;
        estimate.depth = depth_;
        estimate.confidence = confidence_.view();
        writer_->publish(estimate, luma_, frame);
        streams_->frame_published();
    }
    int socket(bool images = true) { return streams_->open(1, {.images = images})->release(); }
    RingWriter &writer() { return *writer_; }

    afterglow_frame frame{}; ///< what publish() says

private:
    std::unique_ptr<RingWriter> writer_;
    std::unique_ptr<StreamNotifier> streams_;
    DepthMap depth_;
    Image<std::uint8_t> confidence_;
    Luma luma_;
};

/// Whether a plane of the C++ header has this size, and these pixels.
template <class Pixel, class At>
bool is(const PlaneView<Pixel> &plane, int width, int height, At at) {
    if (plane.width() != static_cast<std::size_t>(width) ||
        plane.height() != static_cast<std::size_t>(height))
        return false;
    for (int v = 0; v < height; ++v)
        for (int u = 0; u < width; ++u)
            if (plane(static_cast<std::size_t>(u), static_cast<std::size_t>(v)) != at(u, v))
                return false;
    return true;
}

bool is_whole(const Frame &frame) {
    return is(frame.depth, depth_width, depth_height, TwoSizes::depth_at) &&
           is(frame.confidence, depth_width, depth_height, TwoSizes::confidence_at) &&
           is(frame.luma, image_width, image_height, TwoSizes::luma_at);
}

/// What comes of a stream whose daemon sends these memories.
int open_memory(const ReaderFds &memory) {
    int ends[2];
    REQUIRE(::socketpair(AF_UNIX, SOCK_SEQPACKET | SOCK_CLOEXEC, 0, ends) == 0);
    const UniqueFd daemon_end(ends[0]);
    REQUIRE(send_memory(ends[0], memory, 1));
    afterglow_stream *opened = nullptr;
    const int error = afterglow_open_fd(ends[1], &opened);
    afterglow_close(opened);
    return error;
}

} // namespace

TEST_CASE("images and depth of two sizes are told and read, each in its own", "[ipc]") {
    TwoSizes ring;
    afterglow_stream *opened = nullptr;
    REQUIRE(afterglow_open_fd(ring.socket(), &opened) == 0);
    const test::Stream stream(opened);
    const auto plane = [&](std::uint32_t kind) {
        afterglow_plane_info info = {};
        info.size = sizeof info;
        REQUIRE(afterglow_get_plane_info(opened, kind, &info) == 0);
        return info;
    };
    CHECK(plane(AFTERGLOW_PLANE_DEPTH).width == depth_width);
    CHECK(plane(AFTERGLOW_PLANE_DEPTH).height == depth_height);
    CHECK(plane(AFTERGLOW_PLANE_CONFIDENCE).width == depth_width);
    CHECK(plane(AFTERGLOW_PLANE_CONFIDENCE).height == depth_height);
    CHECK(plane(AFTERGLOW_PLANE_LUMA).width == image_width);
    CHECK(plane(AFTERGLOW_PLANE_LUMA).height == image_height);
    afterglow_info info = {};
    info.size = sizeof info;
    REQUIRE(afterglow_get_info(opened, &info) == 0);
    CHECK(info.width == depth_width);
    CHECK(info.height == depth_height);

    ring.publish();
    test::Planes planes(opened);
    REQUIRE(planes.depth.size() == depth_width * depth_height);
    REQUIRE(planes.confidence.size() == depth_width * depth_height);
    REQUIRE(planes.luma.size() == image_width * image_height);
    REQUIRE(afterglow_read_latest(opened, nullptr, planes.wanted, 3) == 0);
    CHECK(planes.depth.back() == TwoSizes::depth_at(depth_width - 1, depth_height - 1));
    CHECK(planes.luma.back() == TwoSizes::luma_at(image_width - 1, image_height - 1));
    // A buffer of depth's size is none for an image.
    afterglow_buffer small = planes.wanted[2];
    small.bytes = depth_width * depth_height;
    ring.publish();
    CHECK(afterglow_read_latest(opened, nullptr, &small, 1) == -EMSGSIZE);

    afterglow_view views[] = {{AFTERGLOW_PLANE_LUMA, 0, nullptr},
                              {AFTERGLOW_PLANE_DEPTH, 0, nullptr}};
    REQUIRE(afterglow_peek(opened, nullptr, views, 2) == 0);
    const auto *luma = static_cast<const std::uint8_t *>(views[0].data);
    CHECK(luma[(image_height - 1) * views[0].stride_bytes + image_width - 1] ==
          TwoSizes::luma_at(image_width - 1, image_height - 1));
    const auto *depth =
        reinterpret_cast<const std::uint16_t *>(static_cast<const std::uint8_t *>(views[1].data) +
                                                (depth_height - 1) * views[1].stride_bytes);
    CHECK(depth[depth_width - 1] == TwoSizes::depth_at(depth_width - 1, depth_height - 1));
    CHECK(afterglow_peek_valid(opened) == 1);
}

TEST_CASE("the C++ header shows images and depth of two sizes", "[ipc]") {
    TwoSizes ring;
    Stream stream = Stream::from_fd(ring.socket());
    ring.publish();
    const std::optional<Frame> copied = stream.read_latest();
    REQUIRE(copied);
    CHECK(is_whole(*copied));
    ring.publish();
    const std::optional<Frame> peeked = stream.peek();
    REQUIRE(peeked);
    CHECK(is_whole(*peeked));
    CHECK(stream.peek_valid());

    Stream depth_only = Stream::from_fd(ring.socket(false));
    ring.publish();
    const std::optional<Frame> dark = depth_only.read_latest();
    REQUIRE(dark);
    CHECK(dark->luma.empty());
    CHECK(is(dark->depth, depth_width, depth_height, TwoSizes::depth_at));
}

TEST_CASE("a stream of two sizes goes on in another memory of the same sizes", "[ipc]") {
    TwoSizes ring;
    Stream stream = Stream::from_fd(ring.socket());
    ring.publish();
    REQUIRE(stream.read_latest());
    REQUIRE(ring.writer().renew(false));
    for (int i = 0; i < 2; ++i)
        ring.publish();
    REQUIRE(stream.wait(std::chrono::seconds(10))); // for the other memory
    const auto &frame = stream.read_latest();
    REQUIRE(frame);
    CHECK(is_whole(*frame));
}

TEST_CASE("readers get the lens that depth is seen through", "[ipc]") {
    TwoSizes ring;
    Stream stream = Stream::from_fd(ring.socket());
    ring.publish();
    std::optional<Frame> frame = stream.read_latest();
    REQUIRE(frame);
    CHECK(frame->info.lens == AFTERGLOW_LENS_PINHOLE);
    for (const double coefficient : frame->info.distortion)
        CHECK(coefficient == 0);

    ring.frame.calibration = 2; // another camera, in the middle of the stream
    ring.frame.lens = AFTERGLOW_LENS_BROWN_CONRADY;
    for (int i = 0; i < 8; ++i)
        ring.frame.distortion[i] = 0.125 * (i + 1);
    ring.publish();
    frame = stream.read_latest();
    REQUIRE(frame);
    CHECK(frame->info.calibration == 2);
    CHECK(frame->info.lens == AFTERGLOW_LENS_BROWN_CONRADY);
    for (int i = 0; i < 8; ++i)
        CHECK(frame->info.distortion[i] == 0.125 * (i + 1));
}

TEST_CASE("a frame whose lens is no number is damaged, a lens of later versions is not", "[ipc]") {
    TwoSizes ring;
    Stream stream = Stream::from_fd(ring.socket());
    ring.frame.lens = 77;
    ring.publish();
    REQUIRE(stream.read_latest());
    ring.frame.distortion[7] = std::numeric_limits<double>::quiet_NaN();
    ring.publish();
    afterglow_frame frame = empty_frame();
    CHECK(afterglow_read_latest(stream.get(), &frame, nullptr, 0) == -EBADMSG);
}

TEST_CASE("no ring is made for images of no size, and memories of two rings are refused", "[ipc]") {
    Intrinsics none = image_camera;
    none.width = 0;
    CHECK_FALSE(RingWriter::create(depth_camera, none));
    CHECK_FALSE(RingWriter::create(none, image_camera));

    TwoSizes ring;
    TwoSizes other;
    const auto fds = [](TwoSizes &of) { return std::move(*of.writer().reader_fds(true)); };
    CHECK(open_memory(fds(ring)) == 0);
    CHECK(open_memory({fds(ring).depth, fds(other).images, 0}) == -EPROTO);
}
