// SPDX-License-Identifier: Apache-2.0
#include "tests/test_ring.hpp"
#include "tests/wait_until.hpp"

#include <cerrno>
#include <cstring>
#include <string>

using namespace afterglow;
using namespace afterglow::test;

TEST_CASE("a ring frame is read as it was published", "[ipc]") {
    // Rows that do not fill whole words, out of images that have wider rows still; more than the
    // workers take at a time.
    const int width = 37;
    const int height = 21;
    const int stride = 50;
    WorkerPool pool(3);
    WorkerPool *const workers = GENERATE(false, true) ? &pool : nullptr;
    const auto writer = std::move(*RingWriter::create({50, 51, 18, 2, width, height}));
    const auto streams = std::move(*StreamNotifier::create(*writer));
    Result<UniqueFd> socket = streams->open(1, {.images = true});
    REQUIRE(socket);
    afterglow_stream *opened = nullptr;
    REQUIRE(afterglow_open_fd(socket->release(), &opened) == 0);
    const Stream stream(opened);
    std::vector<std::uint16_t> depth(stride * height);
    std::vector<std::uint8_t> bytes(stride * height);
    for (int i = 0; i < stride * height; ++i) {
        depth[static_cast<std::size_t>(i)] = static_cast<std::uint16_t>(1000 + i);
        bytes[static_cast<std::size_t>(i)] = static_cast<std::uint8_t>(i);
    }
    Estimate estimate;
    estimate.source = FrameSource::estimated;
    estimate.age_frames = 4;
    estimate.age_ns = 133;
    estimate.inliers = 99;
    estimate.expected_mre = 1.5F;
    estimate.coverage = 87.5F;
    estimate.pose.R = rotation({0.1, 0.2, 0.3});
    estimate.pose.T = {1, 2, 3};
    estimate.world = 5;
    estimate.world_from_camera = estimate.pose.inverse();
    estimate.depth = {depth.data(), width, height, stride};
    estimate.confidence = {bytes.data(), width, height, stride};
    afterglow_frame given{};
    given.sequence = 70;
    given.t_ns = 123456789;
    given.emitter = AFTERGLOW_EMITTER_ON;
    given.flags = AFTERGLOW_FRAME_TRACKED;
    given.measurement = 7;
    given.measurement_t_ns = 120000000;
    given.tof_sequence = 17;
    given.calibration = 3;
    given.fx = 50;
    given.fy = 51;
    given.cx = 18;
    given.cy = 2;
    const afterglow_frame published =
        writer->publish(estimate, {bytes.data() + 3, width, height, stride}, given, workers);

    afterglow_info info = {};
    info.size = sizeof info;
    REQUIRE(afterglow_get_info(stream.get(), &info) == 0);
    CHECK(info.width == width);
    CHECK(info.height == height);
    CHECK(info.calibration == 0); // nothing has been read yet
    CHECK(info.slot_count == 8);
    CHECK(info.generation == writer->generation());
    afterglow_plane_info plane = {};
    plane.size = sizeof plane;
    REQUIRE(afterglow_get_plane_info(stream.get(), AFTERGLOW_PLANE_DEPTH, &plane) == 0);
    CHECK(plane.format == AFTERGLOW_FORMAT_Z16);
    CHECK(plane.pixel_bytes == 2);
    CHECK(plane.unit == 0.001);
    REQUIRE(afterglow_get_plane_info(stream.get(), AFTERGLOW_PLANE_CONFIDENCE, &plane) == 0);
    CHECK(plane.format == AFTERGLOW_FORMAT_GREY);
    CHECK(plane.unit == Approx(0.0005));
    REQUIRE(afterglow_get_plane_info(stream.get(), AFTERGLOW_PLANE_LUMA, &plane) == 0);
    CHECK(plane.width == width);
    CHECK(afterglow_get_plane_info(stream.get(), 77, &plane) == -ENOENT);

    Planes planes(stream.get());
    REQUIRE(planes.depth.size() == width * height);
    REQUIRE(planes.luma.size() == width * height);
    afterglow_frame frame = empty_frame();
    REQUIRE(afterglow_read_latest(stream.get(), &frame, planes.wanted, 3) == 0);
    bool same = true;
    for (int v = 0; v < height; ++v)
        for (int u = 0; u < width; ++u) {
            const int to = v * width + u, from = v * stride + u;
            same = same && planes.depth.data()[to] == depth.data()[from] &&
                   planes.confidence.data()[to] == bytes.data()[from] &&
                   planes.luma.data()[to] == bytes.data()[from + 3];
        }
    CHECK(same);
    CHECK(std::memcmp(&frame, &published, sizeof frame) == 0);
    CHECK(frame.index == 0);
    CHECK(frame.sequence == 70);
    CHECK(frame.t_ns == 123456789);
    CHECK(frame.published_ns > 0);
    CHECK(frame.age_frames == 4);
    CHECK(frame.age_ns == 133);
    CHECK(frame.source == AFTERGLOW_ESTIMATED);
    CHECK(frame.emitter == AFTERGLOW_EMITTER_ON);
    CHECK(frame.flags == AFTERGLOW_FRAME_TRACKED);
    CHECK(frame.measurement == 7);
    CHECK(frame.measurement_t_ns == 120000000);
    CHECK(frame.tof_sequence == 17);
    CHECK(frame.calibration == 3);
    CHECK(frame.world == 5);
    CHECK(frame.inliers == 99);
    CHECK(frame.expected_mre == 1.5F);
    CHECK(frame.coverage == 87.5F);
    const Pose inverse = estimate.pose.inverse();
    for (int row = 0; row < 3; ++row) {
        CHECK(frame.camera_from_measurement[4 * row + 3] == row + 1);
        CHECK(frame.world_from_camera[4 * row + 3] == inverse.T(row));
        for (int column = 0; column < 3; ++column) {
            CHECK(frame.camera_from_measurement[4 * row + column] == estimate.pose.R(row, column));
            CHECK(frame.world_from_camera[4 * row + column] == inverse.R(row, column));
        }
    }
    REQUIRE(afterglow_get_info(stream.get(), &info) == 0);
    CHECK(info.calibration == 3);
    CHECK(info.fy == 51);
}

TEST_CASE("a slow ring reader gets the newest frame and the number of missed ones", "[ipc]") {
    TestRing ring;
    const Stream stream = ring.open();
    Planes planes(stream.get());
    afterglow_frame frame = empty_frame();
    const auto latest = [&] {
        return afterglow_read_latest(stream.get(), &frame, planes.wanted, 3);
    };
    const auto read = [&](std::uint64_t index) {
        return afterglow_read(stream.get(), index, &frame, planes.wanted, 3);
    };

    CHECK(latest() == -EAGAIN);
    CHECK(read(0) == -EAGAIN);
    CHECK(afterglow_wait(stream.get(), 0) == -ETIMEDOUT);
    for (int i = 0; i < 20; ++i)
        ring.publish();
    CHECK(afterglow_wait(stream.get(), 0) == 0);
    REQUIRE(latest() == 0);
    CHECK(frame.index == 19);
    CHECK(planes.are_of(19));
    CHECK(afterglow_skipped(stream.get()) == 0); // nothing before the first one read
    CHECK(latest() == -EAGAIN);
    CHECK(afterglow_wait(stream.get(), 1) == -ETIMEDOUT);

    for (int i = 0; i < 10; ++i)
        ring.publish();
    CHECK(read(20) == -ESTALE);
    CHECK(read(21) == -ESTALE);
    REQUIRE(read(22) == 0);
    CHECK(planes.are_of(22));
    CHECK(afterglow_skipped(stream.get()) == 2);
    REQUIRE(latest() == 0);
    CHECK(frame.index == 29);
    CHECK(afterglow_skipped(stream.get()) == 8);
    REQUIRE(read(25) == 0); // going back changes nothing
    CHECK(planes.are_of(25));
    CHECK(afterglow_skipped(stream.get()) == 8);
    CHECK(latest() == -EAGAIN);
    CHECK(read(30) == -EAGAIN);
    CHECK(read(UINT64_MAX) == -EAGAIN);
}

TEST_CASE("a ring frame is copied only to buffers of sufficient size", "[ipc]") {
    TestRing ring;
    const Stream stream = ring.open();
    ring.publish();
    Planes planes(stream.get());
    const auto latest = [&](const afterglow_buffer *buffers, std::size_t count) {
        return afterglow_read_latest(stream.get(), nullptr, buffers, count);
    };
    afterglow_buffer small = planes.wanted[0];
    --small.bytes;
    afterglow_buffer nowhere = planes.wanted[0];
    nowhere.data = nullptr;
    afterglow_buffer unknown = planes.wanted[0];
    unknown.kind = 77;

    CHECK(latest(&small, 1) == -EMSGSIZE);
    CHECK(latest(&nowhere, 1) == -EINVAL);
    CHECK(latest(&unknown, 1) == -ENOENT);
    CHECK(latest(nullptr, 1) == -EINVAL);
    CHECK(afterglow_read(stream.get(), 0, nullptr, &small, 1) == -EMSGSIZE);
    CHECK(afterglow_plane_bytes(stream.get(), 77) == 0);
    CHECK(latest(nullptr, 0) == 0); // none of the refusals has used the frame up
}

TEST_CASE("libafterglow returns EINVAL for a NULL stream", "[ipc]") {
    afterglow_info info = {};
    info.size = sizeof info;
    afterglow_frame frame = empty_frame();
    CHECK(afterglow_open(nullptr, nullptr) == -EINVAL);
    CHECK(afterglow_open_fd(-1, nullptr) == -EINVAL);
    CHECK(afterglow_get_info(nullptr, &info) == -EINVAL);
    CHECK(afterglow_wait(nullptr, 0) == -EINVAL);
    CHECK(afterglow_fd(nullptr) == -EINVAL);
    CHECK(afterglow_read_latest(nullptr, &frame, nullptr, 0) == -EINVAL);
    CHECK(afterglow_read(nullptr, 0, &frame, nullptr, 0) == -EINVAL);
    CHECK(afterglow_peek(nullptr, &frame, nullptr, 0) == -EINVAL);
    CHECK(afterglow_peek_valid(nullptr) == 0);
    CHECK(afterglow_plane_bytes(nullptr, AFTERGLOW_PLANE_DEPTH) == 0);
    CHECK(afterglow_skipped(nullptr) == 0);
    afterglow_close(nullptr);
}

TEST_CASE("libafterglow refuses structs whose size was not set", "[ipc]") {
    TestRing ring;
    const Stream stream = ring.open();
    ring.publish();
    afterglow_frame frame = empty_frame();
    for (const std::uint32_t size : {0U, 8U, 327U, 4097U, 0xdeadbeefU}) {
        INFO(size);
        frame.size = size;
        CHECK(afterglow_read_latest(stream.get(), &frame, nullptr, 0) == -EINVAL);
        CHECK(afterglow_peek(stream.get(), &frame, nullptr, 0) == -EINVAL);
        CHECK(afterglow_read(stream.get(), 0, &frame, nullptr, 0) == -EINVAL);
    }
    for (const std::uint32_t size : {0U, 23U, 4097U, 0xdeadbeefU}) {
        INFO(size);
        afterglow_options options = {};
        options.size = size;
        afterglow_stream *opened = nullptr;
        CHECK(afterglow_open(&options, &opened) == -EINVAL);
    }
    afterglow_info info = {};
    CHECK(afterglow_get_info(stream.get(), &info) == -EINVAL);
    afterglow_plane_info plane = {};
    CHECK(afterglow_get_plane_info(stream.get(), AFTERGLOW_PLANE_DEPTH, &plane) == -EINVAL);
}

TEST_CASE("libafterglow refuses options that it does not know", "[ipc]") {
    struct Newer {
        afterglow_options options = {};
        std::uint64_t wish = 0;
    } newer;
    newer.options.size = sizeof newer;
    newer.options.bus = "unix:path=/nowhere/bus";
    afterglow_stream *stream = nullptr;
    CHECK(afterglow_open(&newer.options, &stream) == -ENOENT); // it wishes for nothing new
    newer.wish = 1;
    CHECK(afterglow_open(&newer.options, &stream) == -EINVAL);
    newer.wish = 0;
    newer.options.flags = 16;
    CHECK(afterglow_open(&newer.options, &stream) == -EINVAL);
    newer.options.flags = 0;
    newer.options.interval_ms = 1001;
    CHECK(afterglow_open(&newer.options, &stream) == -EINVAL);
}

TEST_CASE("a stream begins with the next frame", "[ipc]") {
    TestRing ring;
    for (int i = 0; i < 5; ++i)
        ring.publish();
    const Stream stream = ring.open();
    CHECK(afterglow_wait(stream.get(), 0) == -ETIMEDOUT);
    CHECK(afterglow_read_latest(stream.get(), nullptr, nullptr, 0) == -EAGAIN);
    CHECK(afterglow_read(stream.get(), 4, nullptr, nullptr, 0) == -ESTALE);
    ring.publish();
    afterglow_frame frame = empty_frame();
    REQUIRE(afterglow_read_latest(stream.get(), &frame, nullptr, 0) == 0);
    CHECK(frame.index == 5);
    CHECK(afterglow_skipped(stream.get()) == 0);
}

TEST_CASE("a stream without images gets none", "[ipc]") {
    TestRing ring;
    const Stream stream = ring.open({});
    ring.publish();
    CHECK(afterglow_plane_bytes(stream.get(), AFTERGLOW_PLANE_LUMA) == 0);
    std::vector<std::uint8_t> luma(64 * 48);
    const afterglow_buffer want = {AFTERGLOW_PLANE_LUMA, 0, luma.data(), luma.size()};
    CHECK(afterglow_read_latest(stream.get(), nullptr, &want, 1) == -ENOENT);
    Planes planes(stream.get());
    REQUIRE(afterglow_read_latest(stream.get(), nullptr, planes.wanted, 2) == 0);
    CHECK(planes.are_of(0));
}

TEST_CASE("the ring wants confidences while a stream asks for them, and publishes unknown ones for "
          "an estimate without",
          "[ipc]") {
    TestRing ring;
    const Stream depth = ring.open({});
    CHECK_FALSE(ring.writer().confidence_wanted());
    DepthMap map(64, 48, std::uint16_t{900});
    map(3, 5) = 0;
    const Luma luma(64, 48);
    Estimate estimate;
    estimate.depth = map;
    afterglow_frame frame = ring.write(); // for what it says of the camera
    ring.writer().publish(estimate, luma, frame);
    Planes planes(depth.get());
    REQUIRE(afterglow_read_latest(depth.get(), nullptr, planes.wanted, planes.count) == 0);
    CHECK(std::ranges::count(planes.confidence, unknown_confidence) == 64 * 48 - 1);
    CHECK(planes.confidence[5 * 64 + 3] == no_confidence);
    {
        const Stream one = ring.open({.confidence = true});
        const Stream other = ring.open({.images = true, .confidence = true});
        CHECK(ring.writer().confidence_wanted());
    }
    CHECK(wait_until([&] { return !ring.writer().confidence_wanted(); }));
    CHECK(ring.streams().count() == 1);
}

TEST_CASE("images are written only while a stream takes them", "[ipc]") {
    TestRing ring;
    const Stream depth = ring.open({});
    ring.publish();
    Result<ReaderFds> fds = ring.writer().reader_fds(true);
    REQUIRE(fds);
    const auto image_bytes = [&] {
        std::vector<unsigned char> bytes(8 * 64 * 48);
        REQUIRE(::pread(fds->images.get(), bytes.data(), bytes.size(), 256) ==
                static_cast<ssize_t>(bytes.size()));
        return bytes;
    };
    const auto no_image = image_bytes();
    CHECK(std::all_of(no_image.begin(), no_image.end(), [](auto byte) { return byte == 0; }));

    const Stream images = ring.open({.images = true});
    CHECK(ring.streams().takes_images());
    Planes planes(images.get());
    for (std::uint64_t index = 1; index < 4; ++index) {
        ring.publish();
        REQUIRE(afterglow_read_latest(images.get(), nullptr, planes.wanted, 3) == 0);
        CHECK(planes.are_of(index));
    }
    CHECK(image_bytes() != no_image);
    CHECK(afterglow_read(images.get(), 0, nullptr, nullptr, 0) == -ESTALE);
    Planes without(depth.get());
    REQUIRE(afterglow_read(depth.get(), 0, nullptr, without.wanted, 2) == 0);
    CHECK(without.are_of(0));
}

TEST_CASE("a peeked frame is valid until it is overwritten", "[ipc]") {
    TestRing ring(64, 48, 4);
    const Stream stream = ring.open();
    CHECK(afterglow_peek_valid(stream.get()) == 0);
    afterglow_view views[2] = {{AFTERGLOW_PLANE_DEPTH, 0, nullptr},
                               {AFTERGLOW_PLANE_LUMA, 0, nullptr}};
    afterglow_frame frame = empty_frame();
    CHECK(afterglow_peek(stream.get(), &frame, views, 2) == -EAGAIN);
    ring.publish();
    REQUIRE(afterglow_peek(stream.get(), &frame, views, 2) == 0);
    CHECK(frame.index == 0);
    const auto *luma = static_cast<const std::uint8_t *>(views[1].data);
    const auto *depth = static_cast<const std::uint16_t *>(views[0].data);
    CHECK(views[0].stride_bytes == 128);
    CHECK(views[1].stride_bytes == 64);
    CHECK(luma[47 * 64 + 63] == TestRing::luma_of(0));
    CHECK(depth[47 * 64 + 63] == TestRing::depth_of(0));
    CHECK(afterglow_peek_valid(stream.get()) == 1);
    CHECK(afterglow_peek(stream.get(), &frame, views, 2) == -EAGAIN); // it has been read
    CHECK(afterglow_peek_valid(stream.get()) == 0);

    ring.publish();
    REQUIRE(afterglow_peek(stream.get(), &frame, views, 2) == 0);
    for (int i = 0; i < 3; ++i) {
        ring.publish();
        CHECK(afterglow_peek_valid(stream.get()) == 1);
    }
    ring.publish();
    CHECK(afterglow_peek_valid(stream.get()) == 0);
    views[0].kind = 77;
    CHECK(afterglow_peek(stream.get(), &frame, views, 1) == -ENOENT);
}

TEST_CASE("nothing that was published before a sleep can be read after it", "[ipc]") {
    TestRing ring;
    const Stream before = ring.open();
    ring.publish();
    ring.publish();
    ring.writer().clear();
    CHECK(afterglow_read_latest(before.get(), nullptr, nullptr, 0) == -EAGAIN);
    CHECK(afterglow_read(before.get(), 0, nullptr, nullptr, 0) == -ESTALE);
    Result<ReaderFds> fds = ring.writer().reader_fds(true);
    REQUIRE(fds);
    for (const UniqueFd *fd : {&fds->depth, &fds->images}) {
        std::vector<unsigned char> slots(8 * 64 * 48);
        REQUIRE(::pread(fd->get(), slots.data(), slots.size(), 320) > 0);
        CHECK(std::all_of(slots.begin(), slots.end(), [](auto byte) { return byte == 0; }));
    }
    ring.publish();
    afterglow_frame frame = empty_frame();
    REQUIRE(afterglow_read_latest(before.get(), &frame, nullptr, 0) == 0);
    CHECK(frame.index == 2);
}

TEST_CASE("afterglow_strerror has a sentence for every error", "[ipc]") {
    for (int error = 0; error < 200; ++error) {
        const std::string sentence = afterglow_strerror(-error);
        CHECK(!sentence.empty());
    }
    CHECK(afterglow_strerror(-EPIPE) == std::string("the daemon has closed the stream"));
    CHECK(afterglow_strerror(1) == std::string("unknown error"));
    CHECK(afterglow_strerror(-100000) == std::string("unknown error"));
}
