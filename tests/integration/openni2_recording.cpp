// SPDX-License-Identifier: Apache-2.0
// Recordings (.oni) that OpenNI2 itself made of afterglow-testcam, played by the driver "openni2"
// and by the unmodified daemon.
#include "afterglow/afterglow.h"
#include "tests/catch.hpp"
#include "tests/open_stream.hpp"
#include "tests/served.hpp"
#include "tests/testcam.hpp"

#include <fmt/format.h>

#include <filesystem>
#include <sstream>
#include <string>
#include <vector>

using namespace afterglow;

namespace {

constexpr int recorded = 20;

/// A recording of the test camera.
std::string record(const Room &room) {
    const Testcam testcam(room, 1);
    const std::string file = room.folder.path() + "/room.oni";
    const Ended ended = run({"oni_recording", "record", file, std::to_string(recorded)});
    INFO(ended.errors);
    REQUIRE(ended.code == 0);
    return file;
}

/// The lines of `oni_recording play`.
std::vector<std::string> play(const std::string &file, const Room &room) {
    const Ended ended = run({"oni_recording", "play", file, room.path});
    INFO(ended.errors);
    REQUIRE(ended.code == 0);
    std::vector<std::string> lines;
    std::istringstream output(ended.output);
    for (std::string line; std::getline(output, line);)
        lines.push_back(line);
    REQUIRE_FALSE(lines.empty());
    return lines;
}

} // namespace

TEST_CASE("an OpenNI2 recording gives the recorded depth maps and reports its end") {
    const Room room;
    const std::string file = record(room);
    std::vector<std::string> lines = play(file, room);
    CHECK(lines.back() == fmt::format("lost the recording '{}' is over", file));
    lines.pop_back();
    // A machine too busy for its pace passes over some.
    REQUIRE(lines.size() >= 2);
    // It records in a thread of its own, and so maybe some more; a second round would be as many.
    CHECK(lines.size() < 2 * recorded);
    for (const std::string &line : lines) {
        INFO(line);
        CHECK(line.starts_with("map "));
        CHECK(line != "map -1");
    }
}

TEST_CASE("an OpenNI2 recording that is truncated or of another format is refused") {
    const Room room;
    const std::string file = record(room);
    // What is not there of the file's end takes no space.
    std::ifstream whole(file, std::ios::binary);
    std::string bytes{std::istreambuf_iterator<char>(whole), {}};
    bytes.erase(bytes.find_last_not_of('\0') + 1);
    const double part = GENERATE(0.0, 0.01, 0.5, 0.99);
    const std::string cut = room.folder.write(
        "cut.oni", bytes.substr(0, static_cast<std::size_t>(part * double(bytes.size()))));
    CHECK(play(cut, room)[0].starts_with(
        fmt::format("refused the OpenNI2 device '{}' cannot be opened", cut)));
}

TEST_CASE("the daemon plays an OpenNI2 recording, reports its end and restarts it") {
    const Room room;
    const std::string file = record(room);
    // Half of 33 ms: whatever the phase between the two is, each map belongs to an image.
    Served served(fmt::format("[color]\ndriver = \"replay\"\n"
                              "[replay]\npath = \"{}\"\nloop = true\n"
                              "[illuminator]\ndriver = \"none\"\n"
                              "[gate]\nmode = \"always-on\"\n"
                              "[tof]\ndriver = \"openni2\"\ndevice = \"{}\"\n"
                              "registration = false\npairing_tolerance_ms = 17\n",
                              room.path, file));
    afterglow_stream *stream = nullptr;
    REQUIRE(open_stream(served.bus.address(), &stream) == 0);
    served.wait_for("State", "running");
    served.wait_for("State", "tof-lost");
    CHECK(served.daemon.errors().find("room.oni' is over") != std::string::npos);
    const double before = served.value("FramesMeasured");
    CHECK(before > 0);
    served.expect([&] { return served.value("FramesMeasured") > before; });
    afterglow_close(stream);
}
