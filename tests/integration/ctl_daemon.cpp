// SPDX-License-Identifier: Apache-2.0
//
// afterglowctl on the daemon itself: what a fake service has not got.
#include "config/calibration_file.hpp"
#include "tests/catch.hpp"
#include "tests/served.hpp"
#include "tests/test_rig.hpp"

#include <algorithm>
#include <chrono>
#include <csignal>
#include <filesystem>
#include <nlohmann/json.hpp>
#include <sstream>
#include <string>
#include <thread>
#include <vector>

namespace {

using Json = nlohmann::json;

using afterglow::RigCalibration;

const std::string drivers = "color.driver = \"synthetic\"\ntof.driver = \"synthetic\"\n"
                            "illuminator.driver = \"synthetic\"\n";
const std::string small_room = drivers + "[synthetic]\nwidth = 160\nheight = 120\nfps = 100\n";

Json json_of(const Served &served, std::vector<std::string> arguments) {
    arguments.emplace_back("--json");
    const Ended ended = served.ctl(arguments);
    INFO(ended.output << ended.errors);
    REQUIRE(ended.code == 0);
    return Json::parse(ended.output, nullptr, false);
}

std::vector<std::string> words(const Served &served, std::vector<std::string> command) {
    command.insert(command.begin(), {"afterglowctl", "--bus", served.bus.address()});
    return command;
}

} // namespace

TEST_CASE("afterglowctl monitor --json prints one document on a line for each frame") {
    const Served served(small_room);
    const Ended monitor = served.ctl({"monitor", "--frames", "5", "--json"});
    REQUIRE(monitor.code == 0);
    std::istringstream lines(monitor.output);
    int count = 0;
    std::int64_t last = -1;
    for (std::string line; std::getline(lines, line); ++count) {
        const Json frame = Json::parse(line, nullptr, false);
        REQUIRE(frame.is_object());
        CHECK(frame["index"] > last);
        last = frame["index"];
        CHECK(frame["published_ns"] > frame["t_ns"]);
        CHECK(frame["world_from_camera"].size() == 12);
        CHECK((frame["source"] == "measured" || frame["source"] == "estimated" ||
               frame["source"] == "none"));
        CHECK(frame["measurement"].is_null() == (frame["source"] == "none"));
    }
    CHECK(count == 5);
}

TEST_CASE("afterglowctl latency measures from capture and from publication") {
    const Served served(small_room);
    const Json latency = json_of(served, {"latency", "--frames", "20"});
    CHECK(latency["frames"] == 20);
    for (const char *from : {"capture_to_here", "publish_to_here"}) {
        CHECK(latency[from]["p50_us"] > 0);
        CHECK(latency[from]["p50_us"] <= latency[from]["p99_us"]);
        CHECK(latency[from]["p99_us"] <= latency[from]["max_us"]);
    }
    // A frame is published after it was captured.
    CHECK(latency["capture_to_here"]["max_us"] > latency["publish_to_here"]["max_us"]);
    CHECK(served.ctl({"latency", "--frames", "20"}).output.find("publish to here ") !=
          std::string::npos);
    CHECK(served.ctl({"latency", "--frames", "0"}).code == 2);
}

TEST_CASE("afterglowctl takes an empty word for a word, not for none") {
    const Served served(small_room);
    CHECK(served.ctl({"mode", ""}).code == 1);
    CHECK(served.ctl({"log-level", ""}).code == 1);
    CHECK(served.ctl({"mode"}).output == "auto\n");
}

TEST_CASE("afterglowctl monitor that is stopped and goes on misses frames, and no more") {
    const Served served(small_room);
    Program monitor(words(served, {"monitor", "--json"}));
    const auto lines = [&] {
        const std::string output = monitor.output();
        return std::count(output.begin(), output.end(), '\n');
    };
    for (int round = 0; round < 20; ++round) {
        const auto before = lines();
        REQUIRE(wait_until([&] { return lines() > before || !monitor.runs(); }));
        monitor.signal(SIGSTOP);
        std::this_thread::sleep_for(std::chrono::milliseconds(5));
        monitor.signal(SIGCONT);
    }
    INFO(monitor.errors());
    CHECK(monitor.runs());
}

TEST_CASE("afterglowctl snapshot --json says which frame it is of, beside the picture") {
    const Served served(small_room);
    const std::string map = served.folder / "shot.pgm";
    const Json shot = json_of(served, {"snapshot", map});
    CHECK(shot["path"] == map);
    CHECK(shot["frame"]["source"] != "none");
    CHECK(std::filesystem::exists(map));
    const Ended piped = served.ctl({"snapshot", "-", "--json"});
    CHECK(piped.code == 0);
    CHECK(piped.output.substr(1, 3) == "PNG");
    CHECK(Json::parse(piped.errors, nullptr, false)["path"] == "-");
}

TEST_CASE("the strictest request of afterglowctl rules while it is held") {
    Served served(small_room);
    const Json before = json_of(served, {"policy", "get", "TargetError"})["target_error"];
    Program loose(words(served, {"request", "--error", "1.5", "--reason", "loose"}));
    Program strict(words(served, {"request", "--error", "0.5", "--reason", "strict"}));
    served.expect([&] { return json_of(served, {"requests"}).size() == 2; });
    const Json policy = json_of(served, {"policy", "get", "TargetError"})["target_error"];
    CHECK(policy["value"] == before["value"]);
    CHECK(policy["effective"] == 0.5);
    REQUIRE(policy["asked_by"].size() == 1);
    CHECK(policy["asked_by"][0]["reason"] == "strict");
    CHECK(policy["asked_by"][0]["pid"] == strict.process());
    strict.signal(SIGKILL);
    served.expect([&] {
        return json_of(served, {"policy", "get", "TargetError"})["target_error"]["effective"] ==
               1.5;
    });
    loose.signal(SIGINT);
    CHECK(loose.wait() == 0);
    served.expect([&] { return json_of(served, {"requests"}).empty(); });
}

TEST_CASE(
    "afterglowctl hold and measure meet in mode off, and the end of the daemon ends the hold") {
    Served served(small_room);
    Program dark(words(served, {"hold", "off", "--reason", "dark room"}));
    served.expect([&] { return json_of(served, {"mode"})["effective_mode"] == "off"; });
    CHECK(json_of(served, {"mode"})["mode"] == "auto");
    const Ended refused = served.ctl({"measure"});
    CHECK(refused.code == 1);
    CHECK(refused.errors.find("`afterglowctl requests` shows who holds the mode off") !=
          std::string::npos);
    served.daemon.signal(SIGKILL);
    CHECK(dark.wait() == 1);
    CHECK(dark.errors().find("afterglowd has ended the request") != std::string::npos);
}

TEST_CASE("afterglowctl measure gives the index of a frame that is measured") {
    const Served served(small_room);
    const Ended asleep = served.ctl({"measure"});
    CHECK(asleep.code == 1);
    CHECK(asleep.errors.find("`afterglowctl monitor`") != std::string::npos);
    CHECK(served.ctl({"policy", "set", "measurement-price", "0"}).code == 0);
    const Program reader(words(served, {"monitor"}));
    REQUIRE(wait_until([&] { return reader.output().find(" measured ") != std::string::npos; }));
    CHECK(json_of(served, {"measure"})["frame"] > 0);
}

TEST_CASE("afterglowctl reloads the daemon, and a wrong configuration changes nothing") {
    const Served served(small_room);
    CHECK(served.ctl({"reload"}).code == 0);
    served.folder.write("a.toml", small_room + "[gate]\ntarget_mre = 3.5\n");
    CHECK(json_of(served, {"reload"})["restart_needed"] == Json::array());
    CHECK(json_of(served, {"policy", "get", "TargetError"})["target_error"]["value"] == 3.5);
    served.folder.write("a.toml", small_room + "[gate]\ntarget_mre = 1\njunk = 1\nmode = \"x\"\n");
    const Ended wrong = served.ctl({"reload"});
    CHECK(wrong.code == 1);
    CHECK(wrong.errors.find("nothing was changed") != std::string::npos);
    CHECK(wrong.errors.find("junk") != std::string::npos);
    CHECK(wrong.errors.find("gate.mode") != std::string::npos);
    CHECK(json_of(served, {"policy", "get", "TargetError"})["target_error"]["value"] == 3.5);

    CHECK(served.ctl({"policy", "save"}).errors.find("--policy FILE") != std::string::npos);
    CHECK(served.ctl({"log-level", "debug"}).code == 0);
    CHECK(served.ctl({"log-level"}).output == "debug\n");
    CHECK(served.ctl({"log-level", "loud"}).code == 1);
}

TEST_CASE("afterglowctl calibration shows the cameras that the daemon works with") {
    const Served registered(small_room);
    const Ended none = registered.ctl({"calibration", "show"});
    CHECK(none.code == 1);
    CHECK(none.errors == "afterglowctl: afterglowd works without a calibration file: depth is "
                         "registered to the colour camera\n");

    const TemporaryFolder folder;
    const RigCalibration rig = afterglow::testing::test_rig();
    const std::string file = folder.write("rig.toml", afterglow::calibration_toml(rig));
    const Served served("rig.calibration = \"" + file + "\"\npublished.camera = \"tof\"\n" +
                        drivers + "[synthetic]\nfps = 100\n");
    CHECK(json_of(served, {"calibration", "show"}) ==
          json_of(served, {"calibration", "show", file}));
    CHECK(served.ctl({"calibration", "show"}).output ==
          served.ctl({"calibration", "show", file}).output);
    const Ended unused = served.ctl({"calibration", "show", "--invert"});
    CHECK(unused.code == 2); // of files
    CHECK(served.ctl({"stats"}).output.find("Calibration") == std::string::npos);
    // Frames come, of the TOF camera's size.
    const Json shot = json_of(served, {"snapshot", served.folder / "shot.pgm"});
    CHECK(shot["frame"]["source"] != "none");
    CHECK(served.folder.read("shot.pgm").substr(0, 9) == "P5\n64 48\n");
    CHECK(served.ctl({"snapshot", served.folder / "shot.png"}).code == 0); // image and depth
    const std::string picture = served.folder.read("shot.png");
    REQUIRE(picture.size() > 24);
    CHECK(static_cast<unsigned char>(picture[19]) + 256 * static_cast<unsigned char>(picture[18]) >
          rig.color.pinhole.width + rig.tof.pinhole.width);
    CHECK(picture[23] == rig.color.pinhole.height); // the larger of both

    // Simulated cameras stay as they are until a restart, and so does what is told of them.
    RigCalibration other = rig;
    other.tof.pinhole.fx = 70;
    folder.write("rig.toml", afterglow::calibration_toml(other));
    CHECK(json_of(served, {"reload"})["restart_needed"] == Json{"rig.calibration"});
    CHECK(json_of(served, {"calibration", "show"})["tof"]["fx"] == rig.tof.pinhole.fx);
}
