// SPDX-License-Identifier: Apache-2.0
#include "tests/catch.hpp"
#include "tests/simulated_boards.hpp"
#include "tools/calibrate/board.hpp"
#include "tools/calibrate/find_board.hpp"

#include <opencv2/imgproc.hpp>

using namespace afterglow;

TEST_CASE("a board that is drawn is found, every corner where it is") {
    for (const char *text : {"chessboard:10x7:30", "chessboard:7x6:30", "charuco:9x6:30",
                             "charuco:10x7:30:0.6", "aprilgrid:6x5:40", "aprilgrid:4x3:40:0.25"}) {
        INFO(text);
        const Board board = *parse_board(text);
        constexpr int side = 40;
        const Luma picture = draw_board(board, side);
        const Corners found = find_board(board, picture);
        const auto places = board.corners();
        REQUIRE(found.size() == places.size());
        for (std::size_t i = 0; i < found.size(); ++i) {
            const Eigen::Vector2d &place = places[static_cast<std::size_t>(found.numbers[i])];
            const Eigen::Vector2d expected =
                (place / board.side_m + Eigen::Vector2d(1, 1)) * side - Eigen::Vector2d(0.5, 0.5);
            CHECK((found.pixels[i] - expected).norm() < 0.05);
        }
    }
}

TEST_CASE("both cameras find a tilted board to a tenth of a pixel, in their own pictures") {
    const RigCalibration rig = narrow_rig();
    const Board board = *parse_board("chessboard:8x5:45");
    SimulatedBoards world(rig, board);
    const Pose pose{rotation({0.4, -0.3, 0.1}), {-0.2, -0.1, 0.7}};
    const BoardMotion rest = [&](double) { return pose; };
    const SimulatedBoards::TofFrame tof = world.tof(rest, 0);
    const auto worst = [&](const Corners &found, const CameraModel &camera, const Pose &at) {
        const auto places = board.corners();
        REQUIRE(found.size() == places.size());
        double sum = 0;
        for (std::size_t i = 0; i < found.size(); ++i) {
            const Eigen::Vector2d &place = places[static_cast<std::size_t>(found.numbers[i])];
            sum += (found.pixels[i] - camera.project(at * Eigen::Vector3d(place.x(), place.y(), 0)))
                       .norm();
        }
        return sum / static_cast<double>(found.size());
    };
    CHECK(worst(find_board(board, world.image(rest, 0)), rig.color, pose) < 0.12);
    CHECK(worst(find_board(board, to_luma(tof.amplitude)), rig.tof, rig.tof_from_color * pose) <
          0.2);
}

TEST_CASE("a picture without the board has no corners, and a blurred one wide edges") {
    const Board board = *parse_board("chessboard:8x5:40");
    CHECK(find_board(board, Luma(320, 240, 128)).empty());
    CHECK(find_board(*parse_board("charuco:8x5:40"), draw_board(board, 30)).empty());
    CHECK(find_board(*parse_board("aprilgrid:6x5:40"), draw_board(board, 30)).empty());
    Luma picture = draw_board(board, 40);
    const Corners corners = find_board(board, picture);
    REQUIRE(!corners.empty());
    CHECK(edge_width(corners, picture) < 2);
    const cv::Mat pixels(picture.height(), picture.width(), CV_8UC1, picture.pixels().data());
    cv::GaussianBlur(pixels, pixels, {}, 4);
    CHECK(edge_width(corners, picture) > 6);
}

TEST_CASE("a board is told by a text, and wrong ones are explained") {
    for (const char *text :
         {"chessboard:10x7:30", "charuco:10x7:30:0.75", "aprilgrid:6x6:25.5:0.3"})
        CHECK(to_text(*parse_board(text)) == text);
    CHECK(parse_board("charuco:9x6:30")->share == 0.75);
    const std::pair<const char *, const char *> wrong[] = {
        {"", "there are chessboard"},
        {"chess:8x5:30", "there are chessboard"},
        {"chessboard", "belong into it"},
        {"chessboard:8x5", "belong into it"},
        {"chessboard:8x5:30:1", "belong into it"},
        {"chessboard:8:30", "a number is expected"},
        {"chessboard:ax5:30", "a number is expected"},
        {"chessboard:8x5:30mm", "a number is expected"},
        {"chessboard:8x6:30", "upside down"},
        {"chessboard:2x5:30", "columns and rows"},
        {"chessboard:99x50:30", "columns and rows"},
        {"chessboard:8x5:0", "millimetres"},
        {"chessboard:8x5:nan", "millimetres"},
        {"charuco:8x5:30:1", "a marker has"},
        {"charuco:40x39:30", "there are markers"},
        {"aprilgrid:6x6:30:2", "a gap has"},
        {"aprilgrid:30x30:30", "there are 587 tags"},
    };
    for (const auto &[text, why] : wrong) {
        INFO(text);
        const auto board = parse_board(text);
        REQUIRE(!board);
        CHECK(board.error().message.find(why) != std::string::npos);
    }
}
