// SPDX-License-Identifier: Apache-2.0
#include "drivers/v4l2/v4l2.hpp"
#include "tests/catch.hpp"
#include "tests/fake_v4l2.hpp"

#include <algorithm>
#include <cerrno>
#include <chrono>
#include <map>

using namespace afterglow;
using namespace std::chrono_literals;

namespace {

constexpr std::int64_t period_ns = 33'333'333;

V4l2TofOptions tof_options() {
    V4l2TofOptions options;
    options.device = "/dev/video0";
    options.camera = {5, 5, 2, 1, 4, 2};
    return options;
}

/// A started TOF camera with one node.
struct OneNodeCamera {
    FakeV4l2 kernel;
    std::unique_ptr<TofSource> source;
    DepthFrame frame{DepthMap(4, 2)};

    OneNodeCamera() {
        kernel.formats = {{V4L2_PIX_FMT_Z16, 4, 2, 30, 2}};
        auto opened = open_v4l2_tof(tof_options(), kernel);
        REQUIRE(opened);
        source = *std::move(opened);
        REQUIRE(source->start());
    }
    Capture read(std::chrono::nanoseconds timeout) { return source->read(frame, timeout); }
};

/// A kernel with a node for depth and one for amplitude, which have one clock.
struct TwoNodes final : SystemCalls {
    FakeV4l2 depth;
    FakeV4l2 amplitude;

    TwoNodes() {
        depth.formats = {{V4L2_PIX_FMT_Z16, 4, 2, 30, 2}};
        amplitude.formats = {{V4L2_PIX_FMT_Y16, 4, 2, 30, 2}};
        amplitude.node = "/dev/video1";
        amplitude.bus_info = "usb-fake-2";
    }

    std::vector<std::string> video_nodes() override {
        auto nodes = depth.video_nodes();
        for (const std::string &node : amplitude.video_nodes())
            nodes.push_back(node);
        return nodes;
    }
    int open(const std::string &path) override {
        FakeV4l2 &kernel = path == amplitude.node ? amplitude : depth;
        const int fd = kernel.open(path);
        opened_[fd] = &kernel;
        return fd;
    }
    int ioctl(int fd, unsigned long request, void *argument) override {
        return of(fd).ioctl(fd, request, argument);
    }
    int poll(int fd, std::chrono::nanoseconds timeout) override {
        FakeV4l2 &kernel = of(fd);
        kernel.now = now_ns();
        return kernel.poll(fd, timeout);
    }
    std::int64_t now_ns() override { return std::max(depth.now, amplitude.now); }

private:
    FakeV4l2 &of(int fd) { return *opened_.at(fd); }
    std::map<int, FakeV4l2 *> opened_;
};

/// A started TOF camera with two nodes.
struct TwoNodeCamera {
    TwoNodes kernel;
    std::unique_ptr<TofSource> source;
    DepthFrame frame{DepthMap(4, 2)};
    std::int64_t t_ns = 0; ///< of the last map

    explicit TwoNodeCamera(bool is_started = true) {
        V4l2TofOptions options = tof_options();
        options.amplitude_device = "/dev/video1";
        auto opened = open_v4l2_tof(options, kernel);
        REQUIRE(opened);
        source = *std::move(opened);
        t_ns = kernel.now_ns();
        if (is_started)
            REQUIRE(source->start());
    }
    /// A frame passes, and the node gives a map.
    void deliver_depth(std::uint8_t value) {
        t_ns += period_ns;
        kernel.depth.now = std::max(kernel.depth.now, t_ns);
        kernel.depth.frames.push_back({std::vector<std::uint8_t>(16, value), t_ns, value});
    }
    void deliver_amplitude(std::uint8_t value, std::int64_t at_ns) {
        kernel.amplitude.frames.push_back({std::vector<std::uint8_t>(16, value), at_ns, value});
    }
    Capture read(std::chrono::nanoseconds timeout = 100ms) { return source->read(frame, timeout); }
    bool has_amplitude(std::uint8_t value) const {
        return frame.amplitude ==
               Image<std::uint16_t>(4, 2, static_cast<std::uint16_t>(value * 0x101));
    }
};

} // namespace

TEST_CASE("depth maps of a V4L2 camera come in order, oldest first") {
    FakeV4l2 kernel;
    kernel.formats = {{V4L2_PIX_FMT_Y12, 4, 2, 30, 2}, {V4L2_PIX_FMT_Z16, 4, 2, 30, 2}};
    auto source = open_v4l2_tof(tof_options(), kernel);
    REQUIRE(source);
    REQUIRE((*source)->start());
    for (std::uint8_t i = 0; i < 3; ++i)
        kernel.frames.push_back({std::vector<std::uint8_t>(16, i), kernel.now, i});
    DepthFrame frame{DepthMap(4, 2)};
    for (std::uint16_t i = 0; i < 3; ++i) {
        REQUIRE((*source)->read(frame, 0ns) == Capture::frame);
        CHECK(frame.depth == DepthMap(4, 2, static_cast<std::uint16_t>(i * 0x101)));
        CHECK(frame.sequence == i);
        CHECK(frame.amplitude.empty());
    }
    CHECK((*source)->read(frame, 0ns) == Capture::none);
}

TEST_CASE("V4L2 maps without stamps that waited for long in the driver's queue are dropped") {
    OneNodeCamera camera;
    FakeV4l2 &kernel = camera.kernel;
    const DepthFrame &frame = camera.frame;
    std::uint32_t number = 0;
    const auto give = [&](int maps) {
        for (int i = 0; i < maps; ++i, ++number)
            kernel.frames.push_back(
                {std::vector<std::uint8_t>(16, 1), 0, number, V4L2_BUF_FLAG_TIMESTAMP_UNKNOWN});
    };
    give(3);
    kernel.now += 5'000'000'000; // in the dark
    CHECK(camera.read(0ns) == Capture::none);
    for (int read = 0; read < 2; ++read) {
        kernel.now += period_ns;
        give(1);
        REQUIRE(camera.read(0ns) == Capture::frame);
        CHECK(frame.t_ns == kernel.now - period_ns);
        CHECK(frame.sequence == number - 1);
    }
}

TEST_CASE("a corrupt V4L2 map without a stamp does not end the belief in stamps") {
    OneNodeCamera camera;
    FakeV4l2 &kernel = camera.kernel;
    const DepthFrame &frame = camera.frame;
    kernel.frames.push_back({{}, 0, 0, V4L2_BUF_FLAG_ERROR});
    CHECK(camera.read(0ns) == Capture::damaged);
    kernel.frames.push_back({std::vector<std::uint8_t>(16, 1), kernel.now - 5'000'000, 1});
    REQUIRE(camera.read(0ns) == Capture::frame);
    CHECK(frame.t_ns == kernel.now - 5'000'000);
}

TEST_CASE("a V4L2 TOF camera with the light off may be silent without a timeout") {
    OneNodeCamera camera;
    CHECK(camera.read(1h) == Capture::none);
    camera.kernel.node.clear();
    CHECK(camera.read(1h) == Capture::lost);
}

TEST_CASE("a V4L2 node is asked for the frames that hold the map, metadata and amplitude") {
    FakeV4l2 kernel;
    // The map's own size is there too, and is not what is wanted.
    kernel.formats = {{V4L2_PIX_FMT_Z16, 4, 2, 30, 2}, {V4L2_PIX_FMT_Z16, 8, 3, 30, 2}};
    V4l2TofOptions options = tof_options();
    options.packing.layout = DepthLayout::amplitude_words;
    options.packing.skip_rows_top = 1;
    auto source = open_v4l2_tof(options, kernel);
    REQUIRE(source);
    REQUIRE((*source)->start());
    std::vector<std::uint8_t> bytes(48, 99);
    for (std::size_t i = 16; i < bytes.size(); i += 4) {
        bytes[i] = 1;
        bytes[i + 1] = 0;
        bytes[i + 2] = 2;
        bytes[i + 3] = 0;
    }
    kernel.frames.push_back({bytes, kernel.now, 0});
    DepthFrame frame;
    REQUIRE((*source)->read(frame, 0ns) == Capture::frame);
    CHECK(frame.depth == DepthMap(4, 2, 1));
    CHECK(frame.amplitude == Image<std::uint16_t>(4, 2, 2));

    bytes.pop_back();
    kernel.frames.push_back({bytes, kernel.now, 1});
    CHECK((*source)->read(frame, 0ns) == Capture::damaged);
    CHECK(kernel.queued.size() == 4);
}

TEST_CASE("a V4L2 node whose frames do not hold the map is refused at the start") {
    FakeV4l2 kernel;
    V4l2TofOptions options = tof_options();
    SECTION("rows of fewer bytes than its format says") {
        kernel.formats = {{V4L2_PIX_FMT_Z16, 4, 2, 30, 1}};
    }
    SECTION("no frames of that size") {
        kernel.formats = {{V4L2_PIX_FMT_Z16, 4, 2, 30, 2}};
        options.packing.skip_rows_bottom = 1;
    }
    auto source = open_v4l2_tof(options, kernel);
    REQUIRE(source);
    const Status started = (*source)->start();
    REQUIRE_FALSE(started);
    CHECK(started.error().code == EINVAL);
    CHECK_FALSE(kernel.streaming);
}

TEST_CASE("V4L2 TOF options that contradict each other are refused") {
    FakeV4l2 kernel;
    V4l2TofOptions options = tof_options();
    SECTION("a scale of zero, or impossible") {
        options.mm_per_unit = GENERATE(0.0, -1.0, 1e9);
    }
    SECTION("a mask with a hole") {
        options.packing.depth_mask = 0xf0f;
    }
    SECTION("a layout that the format cannot have") {
        options.format = "Y16";
        options.packing.layout = DepthLayout::amplitude_after_confidence;
    }
    SECTION("amplitude in the frames and from another node") {
        options.packing.layout = DepthLayout::amplitude_rows;
        options.amplitude_device = "/dev/video1";
    }
    SECTION("amplitude from the same node") {
        options.amplitude_device = options.device;
    }
    SECTION("a format of no node") {
        options.amplitude_format = "Y16";
    }
    SECTION("a format that is not amplitude") {
        options.amplitude_device = "/dev/video1";
        options.amplitude_format = "MJPG";
    }
    CHECK_FALSE(open_v4l2_tof(options, kernel));
    CHECK(kernel.opened == 0);
}

TEST_CASE("a map comes with the amplitude of its own time from a second V4L2 node") {
    TwoNodeCamera camera;
    for (std::uint8_t i = 1; i < 6; ++i) {
        camera.deliver_depth(i);
        camera.deliver_amplitude(static_cast<std::uint8_t>(10 * i), camera.t_ns + 1'000'000);
        REQUIRE(camera.read() == Capture::frame);
        CHECK(camera.frame.depth(0, 0) == i * 0x101);
        CHECK(camera.has_amplitude(static_cast<std::uint8_t>(10 * i)));
    }
    CHECK(camera.source->take_warning().empty());
}

TEST_CASE("images of a second V4L2 node that belong to no map are passed over, later ones kept") {
    TwoNodeCamera camera;
    camera.deliver_amplitude(1, camera.t_ns - period_ns);
    camera.deliver_amplitude(2, camera.t_ns);
    camera.deliver_depth(1);
    camera.deliver_amplitude(4, camera.t_ns + period_ns); // that of this map has been lost
    REQUIRE(camera.read() == Capture::frame);
    CHECK(camera.frame.amplitude.empty());
    camera.deliver_depth(2);
    REQUIRE(camera.read() == Capture::frame);
    CHECK(camera.has_amplitude(4));
}

TEST_CASE("a V4L2 map waits for late amplitude, not beyond the time allowed") {
    TwoNodeCamera camera;
    camera.deliver_depth(1);
    const std::int64_t before = camera.kernel.now_ns();
    CHECK(camera.read(0ns) == Capture::none);
    CHECK(camera.kernel.now_ns() == before);
    CHECK(camera.read(5ms) == Capture::none);
    CHECK(camera.kernel.now_ns() == before + 5'000'000);
    camera.deliver_amplitude(9, camera.t_ns);
    REQUIRE(camera.read(0ns) == Capture::frame);
    CHECK(camera.frame.depth(0, 0) == 0x101);
    CHECK(camera.has_amplitude(9));
}

TEST_CASE("V4L2 maps go on without the amplitude of a silent node, and hardly wait for it") {
    TwoNodeCamera camera;
    const std::int64_t before = camera.kernel.now_ns();
    constexpr int maps = 40;
    std::int64_t waited = 0;
    for (std::uint8_t i = 0; i < maps; ++i) {
        camera.deliver_depth(i);
        const std::int64_t asked = camera.kernel.now_ns();
        REQUIRE(camera.read() == Capture::frame);
        CHECK(camera.frame.amplitude.empty());
        waited += camera.kernel.now_ns() - asked;
    }
    CHECK(waited <= maps / 8 * period_ns / 2);
    CHECK(camera.kernel.now_ns() > before);
    CHECK(camera.source->take_warning().find("without amplitude") != std::string::npos);
    CHECK(camera.source->take_warning().empty()); // said once

    camera.deliver_depth(41);
    camera.deliver_amplitude(9, camera.t_ns);
    REQUIRE(camera.read() == Capture::frame);
    CHECK(camera.has_amplitude(9));
    CHECK(camera.source->take_warning().find("again") != std::string::npos);
}

TEST_CASE("V4L2 maps go on when the node of the amplitude goes, and have it when it is back") {
    TwoNodeCamera camera;
    camera.kernel.amplitude.node.clear();
    camera.deliver_depth(1);
    REQUIRE(camera.read() == Capture::frame);
    CHECK(camera.frame.amplitude.empty());
    CHECK(camera.source->take_warning().find("unplugged") != std::string::npos);

    camera.kernel.amplitude.node = "/dev/video1";
    camera.kernel.amplitude.queued.clear();
    camera.kernel.amplitude.frames.clear();
    bool is_back = false;
    for (std::uint8_t i = 2; i < 100 && !is_back; ++i) {
        camera.deliver_depth(i);
        camera.deliver_amplitude(i, camera.t_ns);
        REQUIRE(camera.read() == Capture::frame);
        is_back = camera.has_amplitude(i);
    }
    CHECK(is_back);
    CHECK(camera.source->take_warning().find("again") != std::string::npos);
}

TEST_CASE("a V4L2 TOF camera starts without its amplitude node, and says so") {
    TwoNodeCamera camera(false);
    SECTION("that is absent") {
        camera.kernel.amplitude.node.clear();
    }
    SECTION("that is in use") {
        camera.kernel.amplitude.failing[VIDIOC_S_FMT] = EBUSY;
    }
    REQUIRE(camera.source->start());
    CHECK(camera.source->take_warning().find("without amplitude") != std::string::npos);
    camera.deliver_depth(1);
    REQUIRE(camera.read() == Capture::frame);
    CHECK(camera.frame.amplitude.empty());
}

TEST_CASE("a V4L2 TOF camera whose amplitude node has another size does not start") {
    TwoNodeCamera camera(false);
    camera.kernel.amplitude.formats = {{V4L2_PIX_FMT_Y16, 8, 4, 30, 2}};
    const Status started = camera.source->start();
    REQUIRE_FALSE(started);
    CHECK(started.error().message.find("/dev/video1") != std::string::npos);
    CHECK_FALSE(camera.kernel.depth.streaming);
}

TEST_CASE("a damaged V4L2 amplitude image costs its map nothing else") {
    TwoNodeCamera camera;
    camera.deliver_depth(1);
    camera.deliver_amplitude(1, camera.t_ns);
    camera.kernel.amplitude.frames.back().bytes.pop_back();
    REQUIRE(camera.read() == Capture::frame);
    CHECK(camera.frame.amplitude.empty());
    camera.deliver_depth(2);
    camera.deliver_amplitude(2, camera.t_ns);
    camera.kernel.amplitude.frames.back().flags |= V4L2_BUF_FLAG_ERROR;
    REQUIRE(camera.read() == Capture::frame);
    CHECK(camera.frame.amplitude.empty());
    CHECK(camera.kernel.amplitude.queued.size() == 4);
    camera.deliver_depth(3);
    camera.deliver_amplitude(3, camera.t_ns);
    REQUIRE(camera.read() == Capture::frame);
    CHECK(camera.has_amplitude(3));
}

TEST_CASE("an amplitude node that floods neither stops depth nor delays it") {
    TwoNodeCamera camera;
    camera.deliver_depth(1);
    for (int i = 0; i < 1000; ++i)
        camera.deliver_amplitude(1, camera.t_ns - period_ns);
    const std::int64_t before = camera.kernel.now_ns();
    Capture capture = Capture::none;
    for (int i = 0; i < 1000 && capture == Capture::none; ++i) {
        capture = camera.read(1ms);
        camera.kernel.depth.now += 1'000'000;
    }
    CHECK(capture == Capture::frame);
    CHECK(camera.kernel.now_ns() - before <= period_ns);
    CHECK(camera.kernel.amplitude.frames.size() > 500); // not all were looked at
}
