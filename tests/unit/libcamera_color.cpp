// SPDX-License-Identifier: Apache-2.0
#include "drivers/libcamera/libcamera.hpp"
#include "tests/allocation_count.hpp"
#include "tests/catch.hpp"
#include "tests/open_descriptors.hpp"
#include "tests/wait_until.hpp"

#include <sys/wait.h>

#include <algorithm>
#include <cerrno>
#include <chrono>
#include <filesystem>
#include <iterator>
#include <string>
#include <vector>

using namespace afterglow;
using afterglow::test::open_descriptors;
using namespace std::chrono_literals;

namespace {

const std::string fake_helper = AFTERGLOW_BIN_DIR "/fake_libcamera";

LibcameraColorOptions options_for(const std::string &device) {
    LibcameraColorOptions options;
    options.device = device;
    options.camera = {5, 5, 2, 1, 4, 2};
    return options;
}

/// A source whose helper plays a script (tests/fake_libcamera.cpp).
struct Camera {
    std::unique_ptr<ColorSource> source;
    ColorFrame frame{Luma(4, 2)};

    explicit Camera(const std::string &script, const std::string &helper = fake_helper) {
        auto opened = open_libcamera_color(options_for(script), helper);
        REQUIRE(opened);
        source = *std::move(opened);
    }
    /// The next that is not Capture::none.
    Capture read() { return source->read(frame, longest_wait); }
    std::string refusal() const {
        const Status started = source->start();
        REQUIRE_FALSE(started);
        return started.error().message;
    }
};

bool has_no_children() {
    return ::waitpid(-1, nullptr, WNOHANG) == -1 && errno == ECHILD;
}

std::string refusal(const LibcameraColorOptions &options) {
    const auto opened = open_libcamera_color(options, fake_helper);
    REQUIRE_FALSE(opened);
    return opened.error().message;
}

} // namespace

TEST_CASE("a libcamera image has luma, capture time and number, and the first is skipped") {
    Camera camera("fffgf");
    REQUIRE(camera.source->start());
    const std::int64_t before =
        std::chrono::nanoseconds(std::chrono::steady_clock::now().time_since_epoch()).count();
    for (const int number : {18, 19, 21}) {
        REQUIRE(camera.read() == Capture::frame);
        CHECK(camera.frame.luma == Luma(4, 2, static_cast<std::uint8_t>(number)));
        CHECK(camera.frame.sequence == static_cast<std::uint64_t>(number) - 18);
        CHECK(camera.frame.t_ns > before - 1'000'000'000);
    }
    CHECK(camera.source->read(camera.frame, 1ms) == Capture::none);
}

TEST_CASE("a late reader of libcamera gets the newest image and a gap in the count") {
    Camera camera("fFFF");
    REQUIRE(camera.source->start());
    std::uint64_t last = 0;
    for (int reads = 0; last < 2 && reads < 3; ++reads) {
        REQUIRE(camera.read() == Capture::frame);
        CHECK(camera.frame.luma(0, 0) == 18 + camera.frame.sequence);
        last = camera.frame.sequence;
    }
    CHECK(last == 2);
}

TEST_CASE("a libcamera image delivered after a newer one is skipped") {
    Camera camera("fFFLF");
    REQUIRE(camera.source->start());
    std::vector<std::uint64_t> numbers;
    while (numbers.empty() || numbers.back() < 2) {
        REQUIRE(camera.read() == Capture::frame);
        numbers.push_back(camera.frame.sequence);
    }
    CHECK(std::is_sorted(numbers.begin(), numbers.end()));
    CHECK(numbers.back() == 2);
    CHECK(camera.source->read(camera.frame, 20ms) == Capture::none);
}

TEST_CASE("a libcamera image marked bad or too short is damaged, and the next is read") {
    Camera camera("ffsf");
    REQUIRE(camera.source->start());
    REQUIRE(camera.read() == Capture::frame);
    CHECK(camera.read() == Capture::damaged);
    CHECK(camera.source->problem() ==
          "an image of the camera 'ffsf' is dropped: it ends too early");
    CHECK(camera.read() == Capture::frame);
    CHECK(camera.frame.sequence == 2);

    Camera bad("ffd");
    REQUIRE(bad.source->start());
    REQUIRE(bad.read() == Capture::frame);
    CHECK(bad.read() == Capture::damaged);
    CHECK(bad.source->problem() == "an image of the camera 'ffd' is dropped: libcamera marks it "
                                   "as bad");
}

TEST_CASE("a lost libcamera camera is reported with the reason and can be restarted") {
    const auto [script, problem] = GENERATE(table<std::string, std::string>({
        {"ffu", "the camera 'X' was unplugged"},
        {"ffx", "the camera 'ffx' was lost: libcamera's process ended"},
        {"ffr", "the camera 'ffr' was lost: libcamera's process ended"},
        {"ffB", "the camera 'ffB' was lost: libcamera's process is not understood"},
        {"ffh", "the camera 'ffh' gives no images"},
    }));
    Camera camera(script);
    for (int round = 0; round < 2; ++round) {
        REQUIRE(camera.source->start());
        REQUIRE(camera.read() == Capture::frame);
        CHECK(camera.frame.sequence == 0);
        CHECK(camera.read() == Capture::lost);
        CHECK(camera.source->problem() == problem);
    }
}

TEST_CASE("a libcamera camera that cannot be opened is reported with the reason") {
    CHECK(Camera("nothing").refusal() == "the camera 'X' is not there (libcamera has none)");
    CHECK(Camera("mute").refusal() == "libcamera does not answer about the camera 'mute'");
    CHECK(Camera("x").refusal() == "libcamera's process ended at the camera 'x'");
    CHECK(Camera("b").refusal() == "the images of the camera 'b' cannot be shared");
    CHECK(Camera("f", "/nowhere/helper").refusal() ==
          "/nowhere/helper cannot be started: No such file or directory");
    CHECK(has_no_children());
}

TEST_CASE("afterglow-libcamera names a camera that is not there") {
    const std::string refusal = Camera("none of these", libcamera_helper()).refusal();
    CHECK(refusal.starts_with("the camera 'none of these' is not there (libcamera has "));
}

TEST_CASE("a closed libcamera camera leaks no process and no descriptor") {
    Camera camera("ff");
    const std::size_t before = open_descriptors();
    for (int i = 0; i < 10; ++i) {
        REQUIRE(camera.source->start());
        REQUIRE(camera.read() == Capture::frame);
        camera.source->stop();
        CHECK(has_no_children());
    }
    CHECK(open_descriptors() == before);
}

TEST_CASE("reading libcamera's images allocates nothing") {
    Camera camera("fffffff");
    REQUIRE(camera.source->start());
    REQUIRE(camera.read() == Capture::frame);
    const std::uint64_t before = allocation_count();
    for (int i = 0; i < 5; ++i)
        REQUIRE(camera.read() == Capture::frame);
    CHECK(allocation_count() == before);
}

TEST_CASE("libcamera options that no camera can satisfy are refused at once") {
    CHECK(refusal(options_for("")) == "no camera is named");
    LibcameraColorOptions options = options_for("cam");
    options.format = "RGB3"; // only libv4lconvert reads it
    CHECK(refusal(options) == "the format 'RGB3' is not one that can be read");
    options.format = "YUYV";
    CHECK(open_libcamera_color(options, fake_helper));
}
