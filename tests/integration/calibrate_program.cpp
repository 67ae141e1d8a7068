// SPDX-License-Identifier: Apache-2.0
//
// afterglow-calibrate as a person runs it, before boards and cameras that are simulated.
#include "config/calibration_file.hpp"
#include "drivers/files/image_file.hpp"
#include "drivers/files/write_recording.hpp"
#include "tests/catch.hpp"
#include "tests/program.hpp"
#include "tests/simulated_boards.hpp"
#include "tests/temporary_folder.hpp"
#include "tools/calibrate/captures.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <csignal>
#include <filesystem>
#include <string>
#include <vector>

using namespace afterglow;

namespace {

const std::string board_text = "chessboard:6x5:60";
const Board board = *parse_board(board_text);

RigCalibration small_rig() {
    RigCalibration rig;
    rig.color = {{290, 291, 162, 118, 320, 240}, Lens::brown_conrady, {-0.1, 0.03}};
    rig.tof = {{205, 206, 113, 84, 224, 172}, Lens::brown_conrady, {-0.05, 0.02}};
    rig.tof_from_color = {rotation({0.02, -0.03, 0.01}), {0.025, 0.003, -0.004}};
    return rig;
}

void record_stills(const std::string &path, const RigCalibration &rig, int count) {
    auto writer = CapturesWriter::create(path, board);
    REQUIRE(writer);
    SimulatedBoards world(rig, board);
    for (const Pose &pose : world.rests(count)) {
        const BoardMotion rest = [&](double) { return pose; };
        const auto tof = world.tof(rest, 0);
        REQUIRE(writer->add_still(world.image(rest, 0), tof.depth, tof.amplitude));
    }
}

bool has(const std::string &text, const std::string &words) {
    INFO(text);
    return text.find(words) != std::string::npos;
}

} // namespace

TEST_CASE("afterglowctl calibrate solve writes the file that the daemon reads, and pictures") {
    const TemporaryFolder folder;
    const std::string captures = folder / "captures", file = folder / "rig.toml";
    const RigCalibration truth = small_rig();
    record_stills(captures, truth, 14);
    const Ended solved = run({"afterglowctl", "calibrate", "solve", captures, "-o", file});
    INFO(solved.output << solved.errors);
    REQUIRE(solved.code == 0);
    CHECK(has(solved.output, "Verdict: "));
    CHECK(has(solved.output, "no moving board was recorded"));
    const auto rig = load_calibration(file);
    REQUIRE(rig);
    CHECK(rig->color.pinhole.fx == Approx(truth.color.pinhole.fx).epsilon(0.01));
    CHECK(rig->tof.pinhole.fx == Approx(truth.tof.pinhole.fx).epsilon(0.01));
    CHECK((rig->tof_from_color.T - truth.tof_from_color.T).norm() < 0.004);
    CHECK(read_luma(captures + "/report/color.png")->width() == 640);
    CHECK(read_luma(captures + "/report/tof.png"));
    CHECK(read_luma(captures + "/report/depth_on_color.png")->width() == 320);

    // The same pictures of a board that is said to be twice as large.
    const std::string refused = folder / "refused.toml";
    const Ended wrong = run(
        {"afterglow-calibrate", "solve", captures, "-o", refused, "--board", "chessboard:6x5:120"});
    CHECK(wrong.code == 1);
    CHECK(has(wrong.output, "Verdict: not usable"));
    CHECK(has(wrong.output, "Measure the board with a ruler"));
    CHECK(has(wrong.errors, "was not written"));
    CHECK(!load_calibration(refused));
}

TEST_CASE("afterglow-calibrate capture takes a view wherever the board of a recording rests") {
    const TemporaryFolder folder;
    RigCalibration registered;
    registered.color = {{290, 290, 160, 120, 320, 240}};
    registered.tof = registered.color;
    SimulatedBoards world(registered, board);
    auto recording = RecordingWriter::create(folder / "recording", registered.color.pinhole);
    REQUIRE(recording);
    std::int64_t t_ns = 1'000'000'000;
    for (const Pose &pose : world.rests(3)) {
        const BoardMotion rest = [&](double) { return pose; };
        const Luma image = world.image(rest, 0);
        const DepthMap depth = world.depth(rest, 0);
        for (int i = 0; i < 9; ++i)
            REQUIRE(recording->add(t_ns += 100'000'000, image, depth));
    }
    const std::string config = folder.write("afterglowd.toml", R"([color]
driver = "replay"
[tof]
driver = "replay"
[illuminator]
driver = "replay"
[replay]
path = "recording"
real_time = false
)");
    const std::string captures = folder / "captures";
    const Ended captured = run({"afterglow-calibrate", "capture", "--config", config, "-o",
                                captures, "--board", board_text});
    INFO(captured.output << captured.errors);
    REQUIRE(captured.code == 0);
    CHECK(has(captured.output, "view 3: 20 corners"));
    CHECK(has(captured.output, "the recording is over, with 3 views"));
    const auto read = read_captures(captures);
    REQUIRE(read);
    CHECK(read->stills.size() == 3);
    CHECK(read_luma(captures + "/preview.png")->width() == 320);

    // Another board is not found: it says so, and ends.
    const Ended none = run({"afterglow-calibrate", "capture", "--config", config, "-o",
                            folder / "other", "--board", "charuco:8x5:30", "--patience", "2"});
    CHECK(none.code == 1);
    CHECK(has(none.errors, "no new view of the board charuco:8x5:30:0.75 in 2 seconds"));
    // And what is there is kept.
    const Ended again = run({"afterglow-calibrate", "capture", "--config", config, "-o", captures,
                             "--board", board_text});
    CHECK(again.code == 1);
    CHECK(has(again.errors, "holds captures already"));
}

TEST_CASE("afterglow-calibrate capture can be stopped, and begun again in the same folder") {
    const TemporaryFolder folder;
    const std::string config = folder.write("afterglowd.toml", R"([color]
driver = "synthetic"
[tof]
driver = "synthetic"
[illuminator]
driver = "synthetic"
)");
    const std::string captures = folder / "captures";
    const std::vector<std::string> command = {
        "afterglow-calibrate", "capture", "--config", config, "-o", captures, "--moving", "2.5"};
    for (const int signal : {SIGTERM, SIGHUP}) {
        Program program(command);
        REQUIRE(wait_until([&] { return has(program.output(), "no board") || !program.runs(); }));
        program.signal(signal);
        CHECK(program.wait() == 1);
        CHECK(has(program.errors(), "stopped with 0 views"));
    }
    const Ended absent = run({"afterglow-calibrate", "capture", "--config",
                              folder.write("absent.toml", "[color]\ndriver = \"replay\"\n[tof]\n"
                                                          "driver = \"replay\"\n[replay]\n"
                                                          "path = \"/nowhere\"\n"),
                              "-o", folder / "none"});
    CHECK(absent.code == 1);
    CHECK_FALSE(std::filesystem::exists(folder / "none"));
}

TEST_CASE("afterglow-calibrate print-board draws at true scale") {
    const TemporaryFolder folder;
    const std::string svg = folder / "board.svg";
    const Ended printed =
        run({"afterglow-calibrate", "print-board", "--board", "chessboard:8x5:35", "-o", svg});
    REQUIRE(printed.code == 0);
    CHECK(has(printed.output, "280.0 x 175.0 mm"));
    CHECK(has(folder.read("board.svg"), "width=\"350.000mm\" height=\"245.000mm\""));
    CHECK(run({"afterglow-calibrate", "print-board", "-o", folder / "board.png"}).code == 0);
    CHECK(run({"afterglow-calibrate", "print-board", "-o", folder / "board.pdf"}).code == 1);
}

TEST_CASE("afterglow-calibrate explains what it cannot do") {
    const TemporaryFolder folder;
    CHECK(run({"afterglow-calibrate"}).code == 2);
    const Ended unknown = run({"afterglow-calibrate", "sovle"});
    CHECK(unknown.code == 2);
    CHECK(has(unknown.errors, "did you mean \"solve\"?"));
    const Ended empty =
        run({"afterglow-calibrate", "solve", folder.path(), "-o", folder / "rig.toml"});
    CHECK(empty.code == 1);
    CHECK(has(empty.errors, "board.txt"));
    CHECK(has(run({"afterglowctl", "calibrate", "solve", "--help"}).output, "--tof-intrinsics"));
    CHECK(run({"afterglowctl", "calibrate", "solve", "x", "-o", "y", "--lens", "thick"}).code == 2);
}
