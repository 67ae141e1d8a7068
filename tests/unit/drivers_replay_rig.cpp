// SPDX-License-Identifier: Apache-2.0
//
// Recordings of two cameras whose depth is not registered to the images.
#include "drivers/files/image_file.hpp"
#include "drivers/simulated/replay.hpp"
#include "tests/catch.hpp"
#include "tests/record_rig.hpp"
#include "tests/temporary_folder.hpp"
#include "tests/test_rig.hpp"

#include <fmt/format.h>

using namespace afterglow;
using namespace std::chrono_literals;
using afterglow::testing::record_rig;
using afterglow::testing::test_rig;

namespace {

constexpr int frames = 3;

/// Three frames of the synthetic room.
struct RecordedRig {
    RecordedRig() {
        const Status recorded = record_rig({.frames = frames, .rig = test_rig()}, path);
        INFO((recorded ? "" : recorded.error().message));
        REQUIRE(recorded);
    }
    /// Stamps each depth map so much later than its image.
    void stamp_depth_later(std::chrono::milliseconds by) const {
        std::string lines;
        for (int k = 0; k < frames; ++k)
            lines += fmt::format("{}.0 rgb/00000{}.png {}.{:03} depth/00000{}.png\n", 7 + k, k,
                                 7 + k, by.count(), k);
        folder.write("r/associations.txt", lines);
    }
    Result<Rig> open(const std::optional<RigCalibration> &rig, ReplayOptions options = {}) const {
        options.path = path;
        options.rig = rig;
        return open_replay(options);
    }
    std::string problem(const std::optional<RigCalibration> &rig,
                        const ReplayOptions &options = {}) const {
        const auto opened = open(rig, options);
        std::string message = opened ? "" : opened.error().message;
        if (const std::size_t at = message.find(path + "/"); at != std::string::npos)
            message.erase(at, path.size() + 1);
        return message;
    }

    TemporaryFolder folder;
    std::string path = folder / "r";
};

} // namespace

TEST_CASE("a replay of two cameras gives images and maps in the sizes of each") {
    const RecordedRig recorded;
    auto rig = recorded.open(test_rig(), {.path = {}, .real_time = false});
    REQUIRE(rig);
    CHECK(rig->color->intrinsics() == test_rig().color.pinhole);
    CHECK(rig->tof->intrinsics() == test_rig().tof.pinhole);
    REQUIRE(rig->color->start());
    REQUIRE(rig->tof->start());
    REQUIRE(rig->illuminator->set(true));
    ColorFrame image{Luma(128, 96)};
    DepthFrame map{DepthMap(64, 48)};
    for (int k = 0; k < frames; ++k) {
        REQUIRE(rig->color->read(image, 0ns) == Capture::frame);
        REQUIRE(rig->tof->read(map, 0ns) == Capture::frame);
        CHECK(image.luma == *read_luma(fmt::format("{}/rgb/00000{}.png", recorded.path, k)));
        CHECK(map.depth == *read_grey16(fmt::format("{}/depth/00000{}.png", recorded.path, k)));
    }
}

TEST_CASE("the maps of two recorded cameras have times of their own, and the calibration's delay") {
    const RecordedRig recorded;
    const auto later = GENERATE(12ms, 60ms);
    recorded.stamp_depth_later(later);
    const double speed = GENERATE(0., 1.); // 0: as fast as can be
    auto rig = recorded.open(test_rig(), {.path = {}, .real_time = speed > 0, .loop = true});
    REQUIRE(rig);
    CHECK(rig->pairing.delay == 4ms);
    CHECK(rig->pairing.tolerance >= later + 4ms); // or this map would belong to no image
    REQUIRE(rig->color->start());
    REQUIRE(rig->tof->start());
    REQUIRE(rig->illuminator->set(true));
    ColorFrame image{Luma(128, 96)};
    DepthFrame map{DepthMap(64, 48)};
    for (int k = 0; k < (speed > 0 ? 1 : 2 * frames); ++k) {
        REQUIRE(rig->color->read(image, 1s) == Capture::frame);
        REQUIRE(rig->tof->read(map, 0ns) == Capture::frame);
        CHECK(std::chrono::nanoseconds(map.t_ns - image.t_ns) == later);
    }
}

TEST_CASE("a recording that is not of the calibration's cameras is refused with both sizes") {
    const RecordedRig recorded;
    RigCalibration wrong = test_rig();
    wrong.color.pinhole.width = 640;
    CHECK(recorded.problem(wrong) == "camera.txt: the images are 128x96, but the colour camera of "
                                     "the calibration has 640x96");
    wrong = test_rig();
    wrong.tof.pinhole.height = 40;
    CHECK(recorded.problem(wrong) ==
          "depth/000002.png: is 64x48, but the TOF camera of the calibration has 64x40");
    CHECK(recorded.problem({}).starts_with(
        "depth/000002.png: is 64x48, but the images are 128x96: depth that is not registered to "
        "them needs the calibration of both cameras"));
    CHECK(recorded.problem(test_rig()).empty());
}

TEST_CASE("one map of another size, or none, is an accident that a replay survives") {
    const RecordedRig recorded;
    const std::string first = recorded.path + "/depth/000000.png";
    SECTION("another size") {
        REQUIRE(write_png(first, DepthMap(16, 12)));
    }
    SECTION("not a picture") {
        recorded.folder.write("r/depth/000000.png", "nothing");
    }
    auto rig = recorded.open(test_rig(), {.path = {}, .real_time = false});
    REQUIRE(rig);
    REQUIRE(rig->color->start());
    REQUIRE(rig->tof->start());
    REQUIRE(rig->illuminator->set(true));
    ColorFrame image{Luma(128, 96)};
    DepthFrame map{DepthMap(64, 48)};
    REQUIRE(rig->color->read(image, 0ns) == Capture::frame);
    CHECK(rig->tof->read(map, 0ns) == Capture::damaged);
    CHECK(rig->tof->problem().starts_with(first));
    REQUIRE(rig->color->read(image, 0ns) == Capture::frame);
    CHECK(rig->tof->read(map, 0ns) == Capture::frame);
}

TEST_CASE("a recording of two cameras is played forwards and at its own speed") {
    const RecordedRig recorded;
    CHECK(recorded.problem(test_rig(), {.path = {}, .order = {.reverse = true}})
              .starts_with("replay: a recording of two cameras is not shown backwards"));
    CHECK(recorded.problem(test_rig(), {.path = {}, .speed = 0.5})
              .starts_with("replay: a recording of two cameras is played at its own speed"));
    CHECK(recorded.problem(test_rig(), {.path = {}, .real_time = false, .speed = 0.5}).empty());
}
