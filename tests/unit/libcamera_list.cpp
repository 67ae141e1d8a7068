// SPDX-License-Identifier: Apache-2.0
#include "drivers/libcamera/libcamera.hpp"
#include "tests/catch.hpp"

#include <cstdlib>
#include <string>

using namespace afterglow;

namespace {

Result<std::vector<LibcameraListing>> list(const char *script) {
    ::setenv("FAKE_LIBCAMERA_LIST", script, 1);
    return list_libcamera_cameras(AFTERGLOW_BIN_DIR "/fake_libcamera");
}

std::string refusal(const char *script) {
    const auto listings = list(script);
    REQUIRE_FALSE(listings);
    return listings.error().message;
}

} // namespace

TEST_CASE("libcamera's cameras are listed with their ids, models and modes") {
    const auto listings = list("cc");
    REQUIRE(listings);
    REQUIRE(listings->size() == 2);
    const LibcameraListing &camera = listings->back();
    CHECK(camera.id == "\\_SB_.CAM");
    CHECK(camera.model == "A model");
    REQUIRE(camera.modes.size() == 1);
    CHECK(camera.modes[0].format == "YUYV");
    CHECK(camera.modes[0].width == 640);
    CHECK(camera.modes[0].height == 480);
    CHECK(list("")->empty());
}

TEST_CASE("a libcamera that fails, dies or hangs while listing is reported as such") {
    CHECK(refusal("n") == "libcamera does not start");
    CHECK(refusal("cx") == "libcamera's process ended");
    CHECK(refusal("cm") == "libcamera does not say which cameras it has");
}

TEST_CASE("afterglow-libcamera lists the cameras") {
    CHECK(list_libcamera_cameras());
}
