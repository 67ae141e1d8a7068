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

TEST_CASE("an image comes with its luma, capture time and number") {
    Camera camera;
    REQUIRE(camera.source->start());
    camera.deliver(40, 9);
    REQUIRE(camera.read() == Capture::frame);
    CHECK(camera.frame.luma == Luma(4, 2, 9));
    CHECK(camera.frame.t_ns == camera.kernel.now);
    CHECK(camera.frame.sequence == 0);
}

TEST_CASE("a read waits no longer than it may, and not at all for a time of 0") {
    Camera camera;
    REQUIRE(camera.source->start());
    const std::int64_t before = camera.kernel.now;
    CHECK(camera.read(0ns) == Capture::none);
    CHECK(camera.kernel.now == before);
    CHECK(camera.read(10ms) == Capture::none);
    CHECK(camera.kernel.now == before + 10'000'000);
}

TEST_CASE("what comes first after a start may be from before, and is passed over") {
    Camera camera;
    REQUIRE(camera.source->start());
    CHECK(camera.kernel.frames.size() == 1);
    CHECK(camera.read() == Capture::none);
    CHECK(camera.kernel.frames.empty());
    CHECK(camera.kernel.queued.size() == 4);
}

TEST_CASE("whoever is late gets the newest image, and the others are a gap") {
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

TEST_CASE("an image that the driver marks as corrupt is dropped and keeps its number") {
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

TEST_CASE("a short image is dropped, though an earlier one lies in the same memory") {
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

TEST_CASE("an unplugged camera is lost, and found again on the node where it comes back") {
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

TEST_CASE("start after a loss opens the device anew without a stop between") {
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

TEST_CASE("a camera that stops with an error is lost") {
    Camera camera;
    REQUIRE(camera.source->start());
    camera.kernel.failing[VIDIOC_DQBUF] = EIO;
    CHECK(camera.read() == Capture::lost);
}

TEST_CASE("a camera that polls as failed, and has nothing to say about it, is lost") {
    Camera camera;
    REQUIRE(camera.source->start());
    camera.kernel.poll_events = POLLERR;
    CHECK(camera.read() == Capture::lost);
}

TEST_CASE("a silent camera is lost after a second, or three before its first image") {
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

TEST_CASE("a slow camera is lost after three frames of silence") {
    Camera camera;
    camera.kernel.formats[0].fps = 1;
    REQUIRE(camera.source->start());
    camera.deliver(0);
    REQUIRE(camera.read() == Capture::frame);
    CHECK(camera.read(2900ms) == Capture::none);
    CHECK(camera.read(200ms) == Capture::lost);
}

TEST_CASE("images that waited while nobody read are no silence") {
    Camera camera;
    REQUIRE(camera.source->start());
    camera.kernel.now += 60'000'000'000;
    camera.deliver(0);
    CHECK(camera.read() == Capture::frame);
}

TEST_CASE("a camera in use by another program is named as such, and later obtained") {
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

TEST_CASE("every call that can fail at the start fails it with a sentence") {
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

TEST_CASE("a camera without the controls for rate and exposure streams all the same") {
    Camera camera;
    camera.kernel.failing[VIDIOC_S_PARM] = ENOTTY;
    camera.kernel.failing[VIDIOC_S_CTRL] = EINVAL;
    REQUIRE(camera.source->start());
    camera.deliver(0);
    CHECK(camera.read() == Capture::frame);
}

TEST_CASE("exposure that lengthens the frames in the dark is turned off") {
    Camera camera;
    camera.kernel.values[V4L2_CID_EXPOSURE_AUTO_PRIORITY] = 1;
    REQUIRE(camera.source->start());
    CHECK(camera.kernel.values[V4L2_CID_EXPOSURE_AUTO_PRIORITY] == 0);
}

TEST_CASE("a buffer that the driver does not take back ends in a loss, not in silence") {
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

TEST_CASE("a request that no device could satisfy is refused when it is opened") {
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
    SECTION("in a format that is not known") {
        bad.format = "H264";
    }
    CHECK_FALSE(open_v4l2_color(bad, kernel));
    CHECK(kernel.opened == 0);
}
