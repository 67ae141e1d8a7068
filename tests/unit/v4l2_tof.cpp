// SPDX-License-Identifier: Apache-2.0
#include "drivers/v4l2/v4l2.hpp"
#include "tests/catch.hpp"
#include "tests/fake_v4l2.hpp"

#include <chrono>

using namespace afterglow;
using namespace std::chrono_literals;

namespace {

V4l2TofOptions tof_options() {
    V4l2TofOptions options;
    options.device = "/dev/video0";
    options.camera = {5, 5, 2, 1, 4, 2};
    return options;
}

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
    }
    CHECK((*source)->read(frame, 0ns) == Capture::none);
}

TEST_CASE("a V4L2 TOF camera with the light off may be silent without a timeout") {
    FakeV4l2 kernel;
    kernel.formats = {{V4L2_PIX_FMT_Z16, 4, 2, 30, 2}};
    auto source = open_v4l2_tof(tof_options(), kernel);
    REQUIRE(source);
    REQUIRE((*source)->start());
    DepthFrame frame{DepthMap(4, 2)};
    CHECK((*source)->read(frame, 1h) == Capture::none);
    kernel.node.clear();
    CHECK((*source)->read(frame, 1h) == Capture::lost);
}

TEST_CASE("a V4L2 depth scale of zero or invalid is refused") {
    FakeV4l2 kernel;
    V4l2TofOptions options = tof_options();
    options.mm_per_unit = GENERATE(0.0, -1.0, 1e9);
    CHECK_FALSE(open_v4l2_tof(options, kernel));
}
