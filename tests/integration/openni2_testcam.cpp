// SPDX-License-Identifier: Apache-2.0
// The unmodified daemon on an OpenNI2 device: afterglow-testcam plays the depth of a recording in
// step with the images that the driver "replay" plays.
#include "afterglow/afterglow.h"
#include "drivers/files/image_file.hpp"
#include "drivers/files/recording.hpp"
#include "tests/catch.hpp"
#include "tests/open_stream.hpp"
#include "tests/served.hpp"
#include "tests/testcam.hpp"

#include <fmt/format.h>

#include <cstdint>
#include <fstream>
#include <string>
#include <utility>
#include <vector>

using namespace afterglow;

namespace {

constexpr int frames = Room::frames;
constexpr int every = 6; ///< of them is measured

std::string configuration(const Room &room, double speed, const std::string &light,
                          const std::string &more) {
    return fmt::format("[color]\ndriver = \"replay\"\n"
                       "[replay]\npath = \"{}\"\nspeed = {}\nin_step = true\nloop = {}\n"
                       "[illuminator]\ndriver = \"{}\"\n"
                       "[gate]\nmode = \"interval\"\ninterval_frames = {}\n"
                       "[daemon]\nring_slots = 64\n"
                       "[tof]\ndriver = \"openni2\"\npairing_wait_ms = 100\n{}",
                       room.path, speed, more.find("loops") != std::string::npos, light, every,
                       more);
}

struct Published {
    afterglow_frame frame = empty_frame();
    DepthMap depth;
};

/// Reads what a daemon publishes until the recording is over.
std::vector<Published> read_all(Served &served, const Room &room) {
    afterglow_stream *stream = nullptr;
    REQUIRE(open_stream(served.bus.address(), &stream) == 0);
    served.wait_for("State", "stopped");
    std::vector<Published> published;
    for (std::uint64_t index = 0; index < frames; ++index) {
        Published one;
        one.depth = DepthMap(room.maps[0].width(), room.maps[0].height());
        const afterglow_buffer want = {AFTERGLOW_PLANE_DEPTH, 0, one.depth.pixels().data(),
                                       2 * one.depth.pixels().size()};
        if (afterglow_read(stream, index, &one.frame, &want, 1) == 0)
            published.push_back(std::move(one));
    }
    afterglow_close(stream);
    CHECK(served.daemon.wait() == 0);
    return published;
}

/// The maps of `afterglow-eval run --dump` with a TOF camera that wakes within a frame.
std::vector<DepthMap> offline(const Room &room) {
    const std::string dump = room.folder.path() + "/dump";
    const Ended ended =
        run({"afterglow-eval", "run", room.path, "--dump", dump, "--wake-latency", "1", "--set",
             "gate.mode=interval", "--set", fmt::format("gate.interval_frames={}", every)});
    INFO(ended.errors);
    REQUIRE(ended.code == 0);
    std::vector<DepthMap> maps;
    for (int k = 0; k < frames; ++k) {
        maps.emplace_back(room.maps[0].width(), room.maps[0].height());
        REQUIRE(read_grey16(fmt::format("{}/{:06}.png", dump, k), maps.back()));
    }
    return maps;
}

bool is_same(const std::vector<Published> &published, const std::vector<DepthMap> &maps) {
    if (published.size() != maps.size())
        return false;
    for (std::size_t k = 0; k < maps.size(); ++k)
        if (published[k].frame.sequence != k || published[k].depth != maps[k])
            return false;
    return true;
}

} // namespace

TEST_CASE(
    "depth of an OpenNI2 device equals the offline result, and its emitter follows the daemon") {
    const Room room(200'000'000);
    const std::vector<DepthMap> expected = offline(room);
    // A machine too busy to keep this pace drops frames, and then measures others: so many tries.
    std::vector<Published> published;
    for (int attempt = 0; attempt < 15 && !is_same(published, expected); ++attempt) {
        const Testcam testcam(room, 1);
        Served served(configuration(room, 1, "openni2-emitter", "warmup_maps = 0\n"));
        published = read_all(served, room);
        INFO(served.daemon.errors());

        const Testcam::Log log = testcam.log();
        const bool kept_pace = is_same(published, expected);
        CHECK_FALSE(published.empty());
        for (const Published &one : published) {
            INFO("frame " << one.frame.sequence);
            CHECK((one.frame.emitter == AFTERGLOW_EMITTER_ON || !log.was_lit(one.frame.t_ns)));
            const bool has_map = std::count(log.maps.begin(), log.maps.end(), one.frame.sequence);
            // A test camera that is late exposes its map of that number when the light is on again.
            if (kept_pace)
                CHECK((one.frame.emitter == AFTERGLOW_EMITTER_ON || !has_map));
            if (one.frame.source == AFTERGLOW_MEASURED) {
                CHECK(has_map);
                CHECK(one.depth == room.maps[one.frame.sequence]);
            }
        }
        for (const auto &[from, to] : log.lit)
            CHECK(to < Testcam::never); // dark at the end
    }
    CHECK(is_same(published, expected));
}

TEST_CASE(
    "the daemon drops maps of an OpenNI2 emitter that still warms up and measures its latency") {
    const Room room;
    const double speed = 0.5;
    const Testcam testcam(room, speed, {{"WAKE_MS", "130"}, {"SETTLING_MAPS", "2"}});
    Served served(configuration(room, speed, "openni2-emitter", "# loops\n"));
    afterglow_stream *stream = nullptr;
    REQUIRE(open_stream(served.bus.address(), &stream) == 0);
    DepthMap depth(room.maps[0].width(), room.maps[0].height());
    const afterglow_buffer want = {AFTERGLOW_PLANE_DEPTH, 0, depth.pixels().data(),
                                   2 * depth.pixels().size()};
    for (int measured = 0; measured < 3;) {
        afterglow_frame frame = empty_frame();
        INFO(served.daemon.errors());
        REQUIRE(afterglow_wait(stream, 60'000) == 0);
        if (afterglow_read_latest(stream, &frame, &want, 1) != 0 ||
            frame.source != AFTERGLOW_MEASURED)
            continue;
        ++measured;
        CHECK(depth == room.maps[frame.sequence % frames]);
        CHECK(frame.emitter == AFTERGLOW_EMITTER_ON);
    }
    CHECK(served.value("WakeLatency") >= 130e6);
    CHECK(served.value("PairingErrorP99") <= 15e6);
    afterglow_close(stream);
    served.wait_for("State", "idle");
    served.daemon.signal(SIGTERM);
    CHECK(served.daemon.wait() == 0);
    const Testcam::Log log = testcam.log();
    CHECK(log.maps.size() >= 3 * 3); // two spoilt ones before each
    REQUIRE_FALSE(log.lit.empty());
    CHECK(log.lit.back().second < Testcam::never);
}

TEST_CASE("an unplugged OpenNI2 device is reported, and used again when it returns") {
    const Room room;
    const Testcam testcam(room, 1);
    Served served(configuration(room, 1, "openni2-emitter", "# loops\n"));
    afterglow_stream *stream = nullptr;
    REQUIRE(open_stream(served.bus.address(), &stream) == 0);
    CHECK(served.ctl({"mode", "always-on"}).code == 0);
    served.wait_for("State", "running");
    testcam.command("unplug");
    served.wait_for("State", "tof-lost");
    CHECK(served.daemon.errors().find("was unplugged") != std::string::npos);
    testcam.command("plug");
    served.wait_for("State", "running");
    afterglow_close(stream);
}

TEST_CASE("the OpenNI2 depth stream can serve as the illuminator switch") {
    const Room room;
    const Testcam testcam(room, 1);
    Served served(configuration(room, 1, "openni2-stream", "# loops\n"));
    afterglow_stream *stream = nullptr;
    REQUIRE(open_stream(served.bus.address(), &stream) == 0);
    served.expect([&] { return served.value("FramesMeasured") >= 3; });
    afterglow_close(stream);
    served.wait_for("State", "idle");
    CHECK(testcam.log().lit.size() >= 3);
}

TEST_CASE("the daemon waits for a missing OpenNI2 device and reports it") {
    const Room room;
    const Testcam testcam(room, 1, {{"PLUGGED", "0"}});
    Served served(configuration(room, 1, "openni2-emitter", "# loops\n"));
    afterglow_stream *stream = nullptr;
    REQUIRE(open_stream(served.bus.address(), &stream) == 0);
    served.wait_for("State", "tof-lost");
    CHECK(served.value("FramesMeasured") == 0);
    testcam.command("plug");
    served.wait_for("State", "running");
    afterglow_close(stream);
}

TEST_CASE("afterglowctl probe lists an OpenNI2 device and its lights, and overwrites no file") {
    const Room room;
    const Testcam testcam(room, 1);
    const Ended devices = run({"afterglowctl", "devices"});
    CHECK(devices.code == 0);
    CHECK(devices.output.find("device = \"testcam://0\"\n    gives 160x120 at 30, 1 mm (fx ") !=
          std::string::npos);
    CHECK(devices.output.find("driver = \"openni2-emitter\"") != std::string::npos);

    const std::string kept = room.folder.write("kept.toml", "mine");
    const Ended refused = run({"afterglowctl", "probe", kept});
    CHECK(refused.code == 1);
    std::string content;
    std::ifstream(kept) >> content;
    CHECK(content == "mine");
}
