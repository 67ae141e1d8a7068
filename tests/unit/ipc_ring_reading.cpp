// SPDX-License-Identifier: Apache-2.0
#include "tests/allocation_count.hpp"
#include "tests/test_ring.hpp"

#include <cerrno>
#include <cstring>
#include <string>

using namespace afterglow;
using namespace afterglow::test;

TEST_CASE("a ring frame is read as it was published", "[ipc]") {
    // Rows that do not fill whole words, out of images that have wider rows still.
    const int width = 37;
    const int height = 5;
    const int stride = 50;
    auto writer = RingWriter::create({50, 51, 18, 2, width, height});
    REQUIRE(writer);
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
    estimate.depth = {depth.data(), width, height, stride};
    estimate.confidence = {bytes.data(), width, height, stride};
    afterglow_frame given{};
    given.sequence = 70;
    given.t_ns = 123456789;
    given.illuminated = 1;
    const afterglow_frame published =
        writer->publish(estimate, {bytes.data() + 3, width, height, stride}, given);

    int ends[2];
    REQUIRE(::socketpair(AF_UNIX, SOCK_SEQPACKET | SOCK_CLOEXEC, 0, ends) == 0);
    const UniqueFd daemon_end(ends[0]);
    afterglow_stream *opened = nullptr;
    REQUIRE(afterglow_open_fds(::dup(writer->fd()), ends[1], &opened) == 0);
    const Stream stream(opened);

    afterglow_stream_info info;
    REQUIRE(afterglow_info(stream.get(), &info) == 0);
    CHECK(info.width == width);
    CHECK(info.height == height);
    CHECK(info.fx == 50);
    CHECK(info.fy == 51);
    CHECK(info.cx == 18);
    CHECK(info.cy == 2);
    CHECK(info.slot_count == 8);
    CHECK(info.plane_count == 3);
    CHECK(info.generation == writer->header().generation);

    Planes planes(stream.get());
    REQUIRE(planes.depth.size() == width * height);
    REQUIRE(planes.luma.size() == width * height);
    afterglow_frame frame{};
    REQUIRE(afterglow_read_latest(stream.get(), &frame, planes.wanted, 3) == 0);
    bool same = true;
    for (int v = 0; v < height; ++v)
        for (int u = 0; u < width; ++u) {
            const auto to = static_cast<std::size_t>(v * width + u);
            const auto from = static_cast<std::size_t>(v * stride + u);
            same = same && planes.depth[to] == depth[from] &&
                   planes.confidence[to] == bytes[from] && planes.luma[to] == bytes[from + 3];
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
    CHECK(frame.illuminated == 1);
    CHECK(frame.inliers == 99);
    CHECK(frame.expected_mre == 1.5F);
    CHECK(frame.coverage == 87.5F);
    for (int row = 0; row < 3; ++row) {
        CHECK(frame.pose[4 * row + 3] == static_cast<float>(row + 1));
        for (int column = 0; column < 3; ++column)
            CHECK(frame.pose[4 * row + column] == static_cast<float>(estimate.pose.R(row, column)));
    }
}

TEST_CASE("a slow ring reader gets the newest frame and the number of missed ones", "[ipc]") {
    TestRing ring;
    UniqueFd daemon_end;
    const Stream stream = ring.open(daemon_end);
    Planes planes(stream.get());
    afterglow_frame frame{};
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
    ring.publish();
    UniqueFd daemon_end;
    const Stream stream = ring.open(daemon_end);
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
    afterglow_stream_info info;
    afterglow_frame frame;
    CHECK(afterglow_open(nullptr, nullptr) == -EINVAL);
    CHECK(afterglow_open_fds(-1, -1, nullptr) == -EINVAL);
    CHECK(afterglow_info(nullptr, &info) == -EINVAL);
    CHECK(afterglow_wait(nullptr, 0) == -EINVAL);
    CHECK(afterglow_fd(nullptr) == -EINVAL);
    CHECK(afterglow_read_latest(nullptr, &frame, nullptr, 0) == -EINVAL);
    CHECK(afterglow_read(nullptr, 0, &frame, nullptr, 0) == -EINVAL);
    CHECK(afterglow_plane_bytes(nullptr, AFTERGLOW_PLANE_DEPTH) == 0);
    CHECK(afterglow_skipped(nullptr) == 0);
    afterglow_close(nullptr);
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

TEST_CASE("publishing a ring frame allocates nothing", "[ipc]") {
    TestRing ring;
    const std::uint64_t before = allocation_count();
    for (int i = 0; i < 20; ++i)
        ring.publish();
    CHECK(allocation_count() == before);
    ::operator delete(::operator new(1)); // the counter counts
    CHECK(allocation_count() == before + 1);
}
