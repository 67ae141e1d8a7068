// SPDX-License-Identifier: Apache-2.0
//
// A recording of two cameras, in the daemon and in afterglow-eval.
#include "drivers/files/image_file.hpp"
#include "tests/catch.hpp"
#include "tests/open_stream.hpp"
#include "tests/private_bus.hpp"
#include "tests/program.hpp"
#include "tests/record_rig.hpp"
#include "tests/test_rig.hpp"

#include <fmt/format.h>

#include <filesystem>
#include <nlohmann/json.hpp>
#include <vector>

using namespace afterglow;
using afterglow::testing::record_rig;
using afterglow::testing::test_rig;
namespace fs = std::filesystem;

namespace {

constexpr int frames = 12;

std::string record(const TemporaryFolder &folder) {
    const std::string path = folder / "room";
    const Status recorded = record_rig({.frames = frames, .rig = test_rig()}, path);
    INFO((recorded ? "" : recorded.error().message));
    REQUIRE(recorded);
    return path;
}

/// What a daemon that measures every fourth frame publishes last.
struct LastFrame {
    DepthMap depth;
    std::uint32_t source = 0;
};
LastFrame play(const TemporaryFolder &folder, const std::string &view) {
    const PrivateBus bus;
    Program daemon(
        {"afterglowd", "--bus", bus.address(), "--config",
         folder.write("a.toml", "color.driver = \"replay\"\ntof.driver = \"replay\"\n"
                                "illuminator.driver = \"replay\"\npublished.camera = \"" +
                                    view +
                                    "\"\n[replay]\npath = \"room\"\nreal_time = false\n[gate]\n"
                                    "mode = \"interval\"\ninterval_frames = 4\n")});
    afterglow_stream *stream = nullptr;
    REQUIRE(wait_until([&] { return !daemon.runs() || open_stream(bus.address(), &stream) == 0; }));
    INFO(daemon.errors());
    REQUIRE(stream);
    afterglow_plane_info plane = {};
    plane.size = sizeof plane;
    REQUIRE(afterglow_get_plane_info(stream, AFTERGLOW_PLANE_DEPTH, &plane) == 0);
    LastFrame last{DepthMap(static_cast<int>(plane.width), static_cast<int>(plane.height))};
    const afterglow_buffer want = {AFTERGLOW_PLANE_DEPTH, 0, last.depth.pixels().data(),
                                   2 * last.depth.pixels().size()};
    afterglow_frame frame = empty_frame();
    REQUIRE(wait_until([&] {
        return afterglow_read_latest(stream, &frame, &want, 1) == 0 && frame.index == frames - 1;
    }));
    last.source = frame.source;
    afterglow_close(stream);
    CHECK(daemon.wait() == 0);
    return last;
}

Ended evaluate(const std::string &recording, const std::vector<std::string> &more) {
    std::vector<std::string> command = {"afterglow-eval", "run", recording};
    command.insert(command.end(), more.begin(), more.end());
    return run(command);
}

} // namespace

TEST_CASE("the daemon publishes of a recording of two cameras what afterglow-eval does") {
    const TemporaryFolder folder;
    const std::string recording = record(folder);
    const auto [view, tof] = GENERATE(std::pair("color", false), std::pair("tof", true));
    const Ended ended =
        evaluate(recording, {"--published", view, "--dump", folder / "offline", "--set",
                             "gate.mode=interval", "--set", "gate.interval_frames=4"});
    INFO(ended.errors);
    REQUIRE(ended.code == 0);
    const LastFrame last = play(folder, view);
    CHECK(last.source == AFTERGLOW_ESTIMATED);
    CHECK(last.depth.width() == (tof ? 64 : 128));
    const auto offline = read_grey16(fmt::format("{}/{:06}.png", folder / "offline", frames - 1));
    REQUIRE(offline);
    CHECK(*offline == last.depth);
}

TEST_CASE("a recording of two cameras is scored against what was recorded, in either view") {
    const TemporaryFolder folder;
    const std::string recording = record(folder);
    const std::string view = GENERATE("color", "tof");
    const Ended ended = evaluate(recording, {"--published", view, "--json"});
    INFO(ended.errors);
    REQUIRE(ended.code == 0);
    const auto score = nlohmann::json::parse(ended.output);
    CHECK(score["frames"] == frames);
    CHECK(score["mre_median"] < 5);
    CHECK(score["mre_median"] > 0);
    CHECK(score["coverage_median"] > 70); // edges of a map of 64 x 48 are a good part of it
}

TEST_CASE("a calibration that a command names takes the place of the recording's own") {
    const TemporaryFolder folder;
    const std::string recording = record(folder);
    fs::rename(recording + "/calibration.toml", folder / "other.toml");
    const Ended without = evaluate(recording, {});
    CHECK(without.code == 1);
    CHECK(without.errors.find("needs the calibration of both cameras") != std::string::npos);
    const Ended with = evaluate(recording, {"--calibration", folder / "other.toml"});
    INFO(with.errors);
    CHECK(with.code == 0);
    CHECK(evaluate(recording, {"--calibration", folder / "none.toml"}).code == 2);
    folder.write("other.toml", "version = 1\n[color]\n");
    const Ended broken = evaluate(recording, {"--calibration", folder / "other.toml"});
    CHECK(broken.code == 1);
    CHECK(broken.errors.find("other.toml:") != std::string::npos);
}

TEST_CASE("what works on registered depth alone refuses a recording of two cameras") {
    const TemporaryFolder folder;
    const std::string recording = record(folder);
    for (const std::vector<std::string> &command :
         {std::vector<std::string>{"run", recording, "--preset", "paper"},
          {"run", recording, "--preset", "oracle"},
          {"ablate", recording},
          {"protocol", recording},
          {"live", "--replay", recording},
          {"import", recording, folder / "imported"}}) {
        std::vector<std::string> words = {"afterglow-eval"};
        words.insert(words.end(), command.begin(), command.end());
        const Ended ended = run(words);
        INFO(command.front());
        CHECK(ended.code == 1);
        CHECK(ended.errors.find("is a recording of two cameras") != std::string::npos);
    }
    const Ended synthetic = run({"afterglow-eval", "run", "synthetic", "--published", "tof"});
    CHECK(synthetic.code == 1);
    const Ended backwards = evaluate(recording, {"--reverse"});
    CHECK(backwards.code == 1);
    CHECK(backwards.errors.find("backwards") != std::string::npos);
}
