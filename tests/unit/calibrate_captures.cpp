// SPDX-License-Identifier: Apache-2.0
#include "drivers/files/image_file.hpp"
#include "tests/catch.hpp"
#include "tests/temporary_folder.hpp"
#include "tools/calibrate/captures.hpp"
#include "tools/calibrate/observe.hpp"
#include "tools/calibrate/still_views.hpp"

#include <string>
#include <vector>

using namespace afterglow;

namespace {

const Board board = *parse_board("chessboard:5x4:40");

std::string refused(const TemporaryFolder &folder) {
    const auto captures = read_captures(folder.path());
    if (!captures)
        return captures.error().message;
    const auto seen = observe(*captures, [](const std::string &) {});
    REQUIRE(!seen);
    return seen.error().message;
}

} // namespace

TEST_CASE("captures that were written are read, and observed") {
    const TemporaryFolder folder;
    const std::string path = folder / "captures";
    auto writer = CapturesWriter::create(path, board);
    REQUIRE(writer);
    const Luma picture = draw_board(board, 40);
    const DepthMap depth(64, 48, 700), amplitude(64, 48, 100);
    REQUIRE(writer->add_still(picture, depth, DepthView()));
    REQUIRE(writer->add_still(picture, depth, amplitude));
    REQUIRE(writer->add_moving_color(1'000'000'001, picture));
    REQUIRE(writer->add_moving_color(1'050'000'000, picture));
    REQUIRE(writer->add_moving_tof(999'000'000, depth, amplitude));
    const auto captures = read_captures(path);
    REQUIRE(captures);
    CHECK(captures->board == board);
    REQUIRE(captures->stills.size() == 2);
    CHECK(captures->stills[0].amplitude.empty());
    CHECK(!captures->stills[1].amplitude.empty());
    REQUIRE(captures->moving_color.size() == 2);
    CHECK(captures->moving_color[0].t_ns == 1'000'000'001);
    REQUIRE(captures->moving_tof.size() == 1);
    CHECK(captures->moving_tof[0].t_ns == 999'000'000);
    std::vector<std::string> said;
    const auto seen = observe(*captures, [&](const std::string &line) { said.push_back(line); });
    REQUIRE(seen);
    CHECK(seen->stills[0].color.size() == 12);
    CHECK(seen->images.size() == 2);
    CHECK(seen->tof_size.width == 64);
    CHECK(said.at(0) == "still_0000.png: colour 12 corners, TOF depth only");
    CHECK(said.at(1) == "still_0001.png: colour 12 corners, TOF no board");
    CHECK(!CapturesWriter::create(path, board));
}

TEST_CASE("captures that are wrong are refused with the file and the reason") {
    const TemporaryFolder folder;
    const auto says = [&](const std::string &words) {
        const std::string message = refused(folder);
        INFO(message);
        CHECK(message.find(words) != std::string::npos);
    };
    says("board.txt");
    folder.write("board.txt", "chessboard:5x5:40\n");
    says("board.txt:1: board \"chessboard:5x5:40\"");
    folder.write("board.txt", "chessboard:5x4:40\n");
    says("still.txt");
    folder.write("still.txt", "# nothing\n");
    says("lists no pictures");
    folder.write("still.txt", "a.png\n");
    says("still.txt:1: files are expected");
    folder.write("still.txt", "a.png d.png\n");
    says("a.png");
    folder.write("a.png", "no picture");
    says("a.png");
    REQUIRE(write_png(folder / "a.png", draw_board(board, 40).view()));
    says("d.png");
    REQUIRE(write_png(folder / "d.png", DepthView(DepthMap(64, 48, 500))));
    REQUIRE(write_png(folder / "e.png", DepthView(DepthMap(60, 48, 500))));
    folder.write("still.txt", "a.png d.png\na.png e.png\n");
    says("e.png: has 60x48 pixels, and the pictures before it of this camera 64x48");
    folder.write("still.txt", "a.png d.png e.png\n");
    says("e.png: has 60x48");
    // Colour and depth mixed up.
    folder.write("still.txt", "d.png a.png\n");
    says("a.png");
    REQUIRE(write_png(folder / "grey.png", LumaView(Luma(640, 480, 90))));
    folder.write("still.txt", "grey.png d.png\n");
    says("no image shows the board chessboard:5x4:40");
    folder.write("moving_color.txt", "1.0 a.png\n");
    says("has moving_color.txt but not moving_tof.txt");
    folder.write("moving_tof.txt", "1.0 d.png\n1.0 d.png\n");
    says("moving_tof.txt:2: the time");
}

TEST_CASE("a view is taken when the board rests at a new place, and only then") {
    using Advice = StillViews::Advice;
    StillViews views(640, 480);
    const auto at = [](double u) {
        Corners corners;
        for (int i = 0; i < 12; ++i) {
            corners.numbers.push_back(i);
            corners.pixels.emplace_back(u + 20 * (i % 4), 100 + 20 * static_cast<int>(i / 4));
        }
        return corners;
    };
    constexpr std::int64_t frame = 100'000'000;
    std::int64_t t = 0;
    CHECK(views.look({}, t += frame) == Advice::no_board);
    // It comes, and moves; it rests; it is taken.
    for (int i = 0; i < 12; ++i)
        CHECK(views.look(at(100 + 10 * i), t += frame) == Advice::moving);
    const std::int64_t rest = t += frame;
    CHECK(views.look(at(300), rest) == Advice::moving);
    Advice advice = Advice::moving;
    while (advice == Advice::moving && t < rest + 10 * frame)
        advice = views.look(at(300.5), t += frame);
    REQUIRE(advice == Advice::take_it);
    CHECK(views.rests_since_ns() == rest);
    views.take(at(300.5));
    CHECK(views.look(at(300), t += frame) == Advice::known);
    // Away and back is known as well.
    CHECK(views.look(at(500), t += frame) == Advice::moving);
    CHECK(views.look(at(302), t += frame) == Advice::moving);
    CHECK(views.look(at(302), t += 10 * frame) == Advice::known);
    CHECK(views.coverage().share() > 0);
    CHECK(views.count() == 1);
}

TEST_CASE("coverage is a grid of cells") {
    Coverage coverage(80, 60);
    CHECK(coverage.share() == 0);
    coverage.add({{0, 1, 2}, {{0, 0}, {79, 59}, {200, 200}}});
    CHECK(coverage.share() == Approx(2.0 / 48));
    CHECK(coverage.seen(0, 0));
    CHECK(coverage.seen(7, 5));
    const std::string empty = "........\n";
    CHECK(coverage.text("") == "#.......\n" + empty + empty + empty + empty + ".......#\n");
}
