// SPDX-License-Identifier: Apache-2.0
#include "drivers/v4l2/v4l2.hpp"
#include "tests/catch.hpp"
#include "tests/fake_v4l2.hpp"

#include <cerrno>
#include <chrono>
#include <poll.h>

using namespace afterglow;
using namespace std::chrono_literals;

namespace {

/// An open, not started source on a fake camera of 4x2 pixels.
struct Camera {
    FakeV4l2 kernel;
    std::unique_ptr<ColorSource> source;
    ColorFrame frame{Luma(4, 2)};

    explicit Camera(const std::string &device = "/dev/video0") { open(device); }

    void open(const std::string &device) {
        V4l2ColorOptions options;
        options.device = device;
        options.camera = {5, 5, 2, 1, 4, 2};
        auto opened = open_v4l2_color(options, kernel);
        REQUIRE(opened);
        source = *std::move(opened);
    }
    /// Has the camera deliver an image whose pixels are all `value`.
    FakeFrame &deliver(std::uint32_t sequence, std::uint8_t value = 7) {
        kernel.frames.push_back({std::vector<std::uint8_t>(8, value), kernel.now, sequence});
        return kernel.frames.back();
    }
    Capture read(std::chrono::nanoseconds timeout = 10ms) { return source->read(frame, timeout); }
};

} // namespace

TEST_CASE("a V4L2 image has luma, capture time and number") {
    Camera camera;
    REQUIRE(camera.source->start());
    camera.deliver(40, 9);
    REQUIRE(camera.read() == Capture::frame);
    CHECK(camera.frame.luma == Luma(4, 2, 9));
    CHECK(camera.frame.t_ns == camera.kernel.now);
    CHECK(camera.frame.sequence == 0);
}

TEST_CASE("a V4L2 read respects its timeout, also of 0") {
    Camera camera;
    REQUIRE(camera.source->start());
    const std::int64_t before = camera.kernel.now;
    CHECK(camera.read(0ns) == Capture::none);
    CHECK(camera.kernel.now == before);
    CHECK(camera.read(10ms) == Capture::none);
    CHECK(camera.kernel.now == before + 10'000'000);
}

TEST_CASE("the first V4L2 image after a start is skipped") {
    Camera camera;
    REQUIRE(camera.source->start());
    CHECK(camera.kernel.frames.size() == 1);
    CHECK(camera.read() == Capture::none);
    CHECK(camera.kernel.frames.empty());
    CHECK(camera.kernel.queued.size() == 4);
}

TEST_CASE("a late V4L2 reader gets the newest image and a gap in the count") {
    Camera camera;
    REQUIRE(camera.source->start());
    camera.deliver(0, 1);
    REQUIRE(camera.read() == Capture::frame);
    camera.deliver(1, 2);
    camera.deliver(2, 3);
    camera.deliver(3, 4);
    REQUIRE(camera.read() == Capture::frame);
    CHECK(camera.frame.luma == Luma(4, 2, 4));
    CHECK(camera.frame.sequence == 3);
    CHECK(camera.kernel.queued.size() == 4);
}

TEST_CASE("a V4L2 image marked corrupt is dropped and keeps its number") {
    Camera camera;
    REQUIRE(camera.source->start());
    camera.deliver(0).flags |= V4L2_BUF_FLAG_ERROR;
    CHECK(camera.read() == Capture::damaged);
    CHECK(camera.source->problem().find("/dev/video0") != std::string::npos);
    camera.deliver(1);
    REQUIRE(camera.read() == Capture::frame);
    CHECK(camera.frame.sequence == 1);
    CHECK(camera.kernel.queued.size() == 4);
}

TEST_CASE("a short V4L2 image is dropped, although its buffer holds an earlier one") {
    Camera camera;
    REQUIRE(camera.source->start());
    for (std::uint32_t sequence = 0; sequence < 8; ++sequence) {
        camera.deliver(sequence).bytes.resize(sequence < 4 ? 8 : 7);
        CHECK(camera.read() == (sequence < 4 ? Capture::frame : Capture::damaged));
    }
    camera.deliver(8).bytes.clear();
    CHECK(camera.read() == Capture::damaged);
    CHECK(camera.kernel.queued.size() == 4);
}

TEST_CASE("an unplugged V4L2 camera is lost, and found again on another node") {
    Camera camera("usb-fake-1");
    REQUIRE(camera.source->start());
    camera.deliver(0);
    REQUIRE(camera.read() == Capture::frame);

    camera.kernel.node.clear();
    CHECK(camera.read() == Capture::lost);
    CHECK(camera.source->problem().find("unplugged") != std::string::npos);
    camera.source->stop();
    const Status absent = camera.source->start();
    REQUIRE_FALSE(absent);
    CHECK(absent.error().code == ENOENT);

    camera.kernel.node = "/dev/video3";
    camera.kernel.queued.clear();
    REQUIRE(camera.source->start());
    camera.deliver(70);
    REQUIRE(camera.read() == Capture::frame);
    CHECK(camera.frame.sequence == 0);
}

TEST_CASE("starting a lost V4L2 camera reopens it without a stop") {
    Camera camera;
    REQUIRE(camera.source->start());
    camera.kernel.failing[VIDIOC_DQBUF] = ENODEV;
    CHECK(camera.read() == Capture::lost);
    camera.kernel.failing.clear();
    REQUIRE(camera.source->start());
    CHECK(camera.kernel.opened == 2);
    camera.deliver(0);
    CHECK(camera.read() == Capture::frame);
}

TEST_CASE("a V4L2 camera whose dequeue fails is lost") {
    Camera camera;
    REQUIRE(camera.source->start());
    camera.kernel.failing[VIDIOC_DQBUF] = EIO;
    CHECK(camera.read() == Capture::lost);
}

TEST_CASE("a V4L2 camera whose poll reports an error alone is lost") {
    Camera camera;
    REQUIRE(camera.source->start());
    camera.kernel.poll_events = POLLERR;
    CHECK(camera.read() == Capture::lost);
}

TEST_CASE("a silent V4L2 camera is lost after one second, or three before its first image") {
    Camera camera;
    REQUIRE(camera.source->start());
    CHECK(camera.read(2900ms) == Capture::none);
    CHECK(camera.read(200ms) == Capture::lost);
    CHECK(camera.source->problem().find("no images") != std::string::npos);

    REQUIRE(camera.source->start());
    camera.deliver(0);
    REQUIRE(camera.read() == Capture::frame);
    CHECK(camera.read(900ms) == Capture::none);
    CHECK(camera.read(200ms) == Capture::lost);
}

TEST_CASE("a slow V4L2 camera is lost after three silent frame periods") {
    Camera camera;
    camera.kernel.formats[0].fps = 1;
    REQUIRE(camera.source->start());
    camera.deliver(0);
    REQUIRE(camera.read() == Capture::frame);
    CHECK(camera.read(2900ms) == Capture::none);
    CHECK(camera.read(200ms) == Capture::lost);
}

TEST_CASE("waiting V4L2 images do not count as silence") {
    Camera camera;
    REQUIRE(camera.source->start());
    camera.kernel.now += 60'000'000'000;
    camera.deliver(0);
    CHECK(camera.read() == Capture::frame);
}

TEST_CASE("a V4L2 camera in use is reported as busy, and opened later") {
    const unsigned long request = GENERATE(static_cast<unsigned long>(VIDIOC_S_FMT),
                                           static_cast<unsigned long>(VIDIOC_REQBUFS),
                                           static_cast<unsigned long>(VIDIOC_STREAMON));
    Camera camera;
    camera.kernel.failing[request] = EBUSY;
    const Status busy = camera.source->start();
    REQUIRE_FALSE(busy);
    CHECK(busy.error().code == EBUSY);
    CHECK(busy.error().message.find("in use") != std::string::npos);
    camera.kernel.failing.clear();
    camera.kernel.queued.clear();
    CHECK(camera.source->start());
}

TEST_CASE("every failing call while a V4L2 camera starts is reported with a sentence") {
    const unsigned long request = GENERATE(
        static_cast<unsigned long>(VIDIOC_QUERYCAP), static_cast<unsigned long>(VIDIOC_ENUM_FMT),
        static_cast<unsigned long>(VIDIOC_S_FMT), static_cast<unsigned long>(VIDIOC_REQBUFS),
        static_cast<unsigned long>(VIDIOC_QUERYBUF), static_cast<unsigned long>(VIDIOC_QBUF),
        static_cast<unsigned long>(VIDIOC_STREAMON));
    Camera camera;
    camera.kernel.failing[request] = EINVAL;
    const Status failed = camera.source->start();
    REQUIRE_FALSE(failed);
    CHECK(failed.error().message.find("/dev/video0") != std::string::npos);
    CHECK_FALSE(camera.kernel.streaming);
}

TEST_CASE("a V4L2 camera without rate and exposure controls streams") {
    Camera camera;
    camera.kernel.failing[VIDIOC_S_PARM] = ENOTTY;
    camera.kernel.failing[VIDIOC_S_CTRL] = EINVAL;
    REQUIRE(camera.source->start());
    camera.deliver(0);
    CHECK(camera.read() == Capture::frame);
}

TEST_CASE("starting a V4L2 camera disables exposure-priority frame rates") {
    Camera camera;
    camera.kernel.values[V4L2_CID_EXPOSURE_AUTO_PRIORITY] = 1;
    REQUIRE(camera.source->start());
    CHECK(camera.kernel.values[V4L2_CID_EXPOSURE_AUTO_PRIORITY] == 0);
}

TEST_CASE("a V4L2 buffer that cannot be requeued loses the camera") {
    Camera camera;
    REQUIRE(camera.source->start());
    REQUIRE(camera.read() == Capture::none); // the first is behind us
    camera.kernel.failing[VIDIOC_QBUF] = EINVAL;
    for (std::uint32_t sequence = 0; sequence < 4; ++sequence) {
        camera.deliver(sequence);
        REQUIRE(camera.read() == Capture::frame);
    }
    Capture last = Capture::none;
    for (int i = 0; i < 20 && last == Capture::none; ++i) {
        camera.deliver(9);
        last = camera.read(100ms);
    }
    CHECK(last == Capture::lost);
}

TEST_CASE("V4L2 options that no device can satisfy are refused when opened") {
    V4l2ColorOptions good;
    good.device = "/dev/video0";
    good.camera = {5, 5, 2, 1, 4, 2};
    FakeV4l2 kernel;
    CHECK(open_v4l2_color(good, kernel));
    V4l2ColorOptions bad = good;
    SECTION("without a device") {
        bad.device.clear();
    }
    SECTION("without a size") {
        bad.camera.width = 0;
    }
    SECTION("without a focal length") {
        bad.camera.fx = 0;
    }
    SECTION("without a rate") {
        bad.fps = 0;
    }
    SECTION("with an unknown format") {
        bad.format = "H264";
    }
    CHECK_FALSE(open_v4l2_color(bad, kernel));
    CHECK(kernel.opened == 0);
}
