// SPDX-License-Identifier: Apache-2.0
#include "drivers/files/image_file.hpp"
#include "drivers/files/write_recording.hpp"
#include "drivers/simulated/replay.hpp"
#include "tests/catch.hpp"
#include "tests/temporary_folder.hpp"

#include <array>
#include <filesystem>

using namespace afterglow;
using namespace std::chrono_literals;

namespace {

constexpr int frames = 5;
const Intrinsics camera{20, 20, 7.5, 5.5, 16, 12};

/// A recording of five frames, 40 ms apart from 7 s on; luma and depth tell their number.
class Recorded {
public:
    Recorded() {
        auto writer = RecordingWriter::create(folder / "r", camera);
        REQUIRE(writer);
        for (int k = 0; k < frames; ++k)
            REQUIRE(writer->add(time_ns(k), Luma(16, 12, static_cast<std::uint8_t>(10 * k)),
                                DepthMap(16, 12, static_cast<std::uint16_t>(1000 + k))));
    }
    static std::int64_t time_ns(int k) { return 7'000'000'000 + k * 40'000'000; }
    std::string color(int k) const { return folder / ("r/rgb/00000" + std::to_string(k) + ".png"); }
    std::string depth(int k) const {
        return folder / ("r/depth/00000" + std::to_string(k) + ".png");
    }
    Rig open(ReplayOptions options = {}) const {
        options.path = folder / "r";
        options.real_time = false;
        auto rig = open_replay(options);
        REQUIRE(rig);
        REQUIRE(rig->color->start());
        REQUIRE(rig->tof->start());
        return *std::move(rig);
    }

    TemporaryFolder folder;
};

struct Frames {
    ColorFrame color{Luma(16, 12)};
    DepthFrame depth{DepthMap(16, 12)};
};

void corrupt(const std::string &path) {
    std::filesystem::resize_file(path, std::filesystem::file_size(path) / 2);
}

bool contains(const std::string &text, const std::string &part) {
    return text.find(part) != std::string::npos;
}

} // namespace

TEST_CASE("a replay gives the recording's images, depth and times") {
    const Recorded recorded;
    Rig rig = recorded.open();
    CHECK(rig.color->intrinsics() == camera);
    CHECK(rig.tof->intrinsics() == camera);
    CHECK_FALSE(rig.illuminator->lit());
    REQUIRE(rig.illuminator->set(true));
    Frames f;
    for (int k = 0; k < frames; ++k) {
        REQUIRE(rig.color->read(f.color, 0ns) == Capture::frame);
        CHECK(f.color.luma == Luma(16, 12, static_cast<std::uint8_t>(10 * k)));
        CHECK(f.color.t_ns == Recorded::time_ns(k));
        REQUIRE(rig.tof->read(f.depth, 0ns) == Capture::frame);
        CHECK(f.depth.depth == DepthMap(16, 12, static_cast<std::uint16_t>(1000 + k)));
        CHECK(f.depth.t_ns == f.color.t_ns);
    }
    CHECK(rig.color->read(f.color, 0ns) == Capture::ended);
}

TEST_CASE(
    "a replay gives registered depth maps their recorded times, and tells them in the dark too") {
    const Recorded recorded;
    const std::array late_ms{9, -14};
    recorded.folder.write("r/associations.txt", "7.000 rgb/000000.png 7.009 depth/000000.png\n"
                                                "7.040 rgb/000001.png 7.026 depth/000001.png\n");
    const bool lit = GENERATE(false, true);
    Rig rig = recorded.open();
    CHECK_FALSE(rig.tof->exposure_ns()); // of no image
    REQUIRE(rig.illuminator->set(lit));
    Frames f;
    for (const int late : late_ms) {
        REQUIRE(rig.color->read(f.color, 0ns) == Capture::frame);
        const std::int64_t exposed_ns = f.color.t_ns + late * 1'000'000;
        CHECK(rig.tof->exposure_ns() == exposed_ns);
        CHECK(rig.tof->read(f.depth, 0ns) == (lit ? Capture::frame : Capture::none));
        if (lit)
            CHECK(f.depth.t_ns == exposed_ns);
    }
}

TEST_CASE("a replay changes the exposure of its images alone, and always in the same way") {
    const Recorded recorded;
    ReplayOptions options;
    options.exposure_changes = 2;
    Rig rig = recorded.open(options), again = recorded.open(options);
    REQUIRE(rig.illuminator->set(true));
    Frames f, g;
    bool changed = false;
    for (int k = 0; k < frames; ++k) {
        REQUIRE(rig.color->read(f.color, 0ns) == Capture::frame);
        REQUIRE(again.color->read(g.color, 0ns) == Capture::frame);
        CHECK(f.color.luma == g.color.luma);
        changed |= f.color.luma != Luma(16, 12, static_cast<std::uint8_t>(10 * k));
        REQUIRE(rig.tof->read(f.depth, 0ns) == Capture::frame);
        CHECK(f.depth.depth == DepthMap(16, 12, static_cast<std::uint16_t>(1000 + k)));
    }
    CHECK(changed);
}

TEST_CASE("a looping replay continues timestamps and frame numbers") {
    const Recorded recorded;
    Rig rig = recorded.open({.path = {}, .loop = true});
    Frames f;
    for (int k = 0; k < 3 * frames; ++k) {
        REQUIRE(rig.color->read(f.color, 0ns) == Capture::frame);
        CHECK(f.color.sequence == static_cast<std::uint64_t>(k));
        CHECK(f.color.t_ns == Recorded::time_ns(k));
        CHECK(f.color.luma(0, 0) == 10 * (k % frames));
    }
}

TEST_CASE("a replay ends before its timestamps overflow") {
    const Recorded recorded;
    std::filesystem::remove(recorded.folder / "r/associations.txt");
    recorded.folder.write("r/associations.txt",
                          "0 rgb/000000.png 0 depth/000000.png\n"
                          "3999999999 rgb/000001.png 3999999999 depth/000001.png\n");
    Rig rig = recorded.open({.path = {}, .loop = true});
    Frames f;
    std::int64_t last_ns = -1;
    Capture capture = Capture::frame;
    for (int k = 0; k < 10 && capture == Capture::frame; ++k) {
        capture = rig.color->read(f.color, 0ns);
        if (capture == Capture::frame) {
            CHECK(f.color.t_ns > last_ns);
            last_ns = f.color.t_ns;
        }
    }
    CHECK(capture == Capture::ended);
}

TEST_CASE("a replay opens no depth file while the light is off") {
    const Recorded recorded;
    for (int k = 0; k < frames; ++k) {
        if (k != 2)
            corrupt(recorded.depth(k));
    }
    std::filesystem::remove(recorded.depth(1));
    Rig rig = recorded.open();
    Frames f;
    for (int k = 0; k < frames; ++k) {
        REQUIRE(rig.color->read(f.color, 0ns) == Capture::frame);
        REQUIRE(rig.illuminator->set(k == 2));
        CHECK(rig.tof->read(f.depth, 0ns) == (k == 2 ? Capture::frame : Capture::none));
    }
    CHECK(rig.tof->problem().empty());
    CHECK(f.depth.depth == DepthMap(16, 12, 1002));
}

TEST_CASE("a replay names a damaged, missing or wrong-sized depth file and reads the next") {
    const Recorded recorded;
    corrupt(recorded.depth(0));
    std::filesystem::remove(recorded.depth(1));
    std::filesystem::remove(recorded.depth(2));
    REQUIRE(write_png(recorded.depth(2), DepthMap(12, 16, 1000)));
    std::filesystem::remove(recorded.depth(3));
    REQUIRE(write_png(recorded.depth(3), Luma(16, 12, 100))); // 8 bits
    Rig rig = recorded.open();
    REQUIRE(rig.illuminator->set(true));
    Frames f;
    for (int k = 0; k < 4; ++k) {
        REQUIRE(rig.color->read(f.color, 0ns) == Capture::frame);
        CHECK(rig.tof->read(f.depth, 0ns) == Capture::damaged);
        CHECK(contains(rig.tof->problem(), recorded.depth(k)));
    }
    REQUIRE(rig.color->read(f.color, 0ns) == Capture::frame);
    CHECK(rig.tof->read(f.depth, 0ns) == Capture::frame);
}

TEST_CASE("a replay names a damaged, missing or wrong-sized image and reads the next") {
    const Recorded recorded;
    corrupt(recorded.color(0));
    std::filesystem::remove(recorded.color(1));
    std::filesystem::remove(recorded.color(2));
    REQUIRE(write_png(recorded.color(2), Luma(17, 12)));
    Rig rig = recorded.open();
    Frames f;
    for (int k = 0; k < 3; ++k) {
        CHECK(rig.color->read(f.color, 0ns) == Capture::damaged);
        CHECK(contains(rig.color->problem(), recorded.color(k)));
    }
    REQUIRE(rig.color->read(f.color, 0ns) == Capture::frame);
    CHECK(f.color.sequence == 3);
}

TEST_CASE("a replay delivers a depth map of zeros like any other") {
    const Recorded recorded;
    std::filesystem::remove(recorded.depth(0));
    REQUIRE(write_png(recorded.depth(0), DepthMap(16, 12)));
    Rig rig = recorded.open();
    REQUIRE(rig.illuminator->set(true));
    Frames f;
    REQUIRE(rig.color->read(f.color, 0ns) == Capture::frame);
    CHECK(rig.tof->read(f.depth, 0ns) == Capture::frame);
    CHECK(f.depth.depth == DepthMap(16, 12));
}

TEST_CASE("a replay with an empty recording or negative options is refused") {
    const Recorded recorded;
    const TemporaryFolder empty;
    CHECK_FALSE(open_replay({.path = empty.path()}));
    CHECK_FALSE(open_replay({.path = recorded.folder / "r", .wake_latency_frames = -1}));
    CHECK_FALSE(open_replay({.path = recorded.folder / "r", .frames = -1}));
    CHECK_FALSE(open_replay({.path = recorded.folder / "r", .exposure_changes = -1}));
    CHECK_FALSE(open_replay({.path = recorded.folder / "r", .exposure_changes = 5}));
}
