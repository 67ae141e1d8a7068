// SPDX-License-Identifier: Apache-2.0
//
// Rigs whose truth is known, found again from the corners and depths that they see.
#include "tests/catch.hpp"
#include "tests/simulated_boards.hpp"
#include "tools/calibrate/assessment.hpp"
#include "tools/calibrate/depth_fit.hpp"
#include "tools/calibrate/rig_fit.hpp"
#include "tools/calibrate/timing_fit.hpp"

#include <fmt/format.h>

#include <numbers>

using namespace afterglow;

namespace {

const Board board = *parse_board("chessboard:8x5:45");

/// 110 degrees, whose distance is told along the ray.
RigCalibration wide_rig() {
    RigCalibration rig = narrow_rig();
    rig.color = {{420, 420, 645, 355, 1280, 720}, Lens::kannala_brandt, {-0.02, 0.003, 0.001}};
    rig.range_along_ray = true;
    return rig;
}

std::vector<BoardView> look(SimulatedBoards &world, int count, double tilt = 0.7) {
    std::vector<BoardView> views;
    for (const Pose &pose : world.rests(count, tilt)) {
        const BoardMotion rest = [&](double) { return pose; };
        views.push_back({fmt::format("view {}", views.size()), world.corners_in_image(rest, 0),
                         world.corners_in_tof(rest, 0), world.depth(rest, 0)});
    }
    return views;
}

Result<RigFit> fit(const RigCalibration &rig, const std::vector<BoardView> &views,
                   const RigWishes &wishes = {}) {
    return fit_rig(board, views, rig.color.pinhole, rig.tof.pinhole, wishes);
}

void check_intrinsics(const CameraModel &found, const CameraModel &truth, double focal,
                      double center_px) {
    CHECK(found.pinhole.fx == Approx(truth.pinhole.fx).epsilon(focal));
    CHECK(found.pinhole.fy == Approx(truth.pinhole.fy).epsilon(focal));
    CHECK(found.pinhole.cx == Approx(truth.pinhole.cx).margin(center_px));
    CHECK(found.pinhole.cy == Approx(truth.pinhole.cy).margin(center_px));
}

void check_extrinsics(const Pose &found, const Pose &truth, double mm, double degrees) {
    CHECK(1000 * (found.T - truth.T).norm() < mm);
    CHECK((found * truth.inverse()).angle() * 180 / std::numbers::pi < degrees);
}

bool mentions(const std::string &text, const std::string &words) {
    INFO(text);
    return text.find(words) != std::string::npos;
}

} // namespace

TEST_CASE("two cameras that see boards are found: lenses, and where the TOF camera is") {
    const RigCalibration rig = GENERATE(narrow_rig(), wide_rig());
    SimulatedBoards world(rig, board);
    const auto views = look(world, 30);
    const auto found = fit(rig, views);
    REQUIRE(found);
    check_intrinsics(found->rig.color, rig.color, 0.003, 1);
    check_intrinsics(found->rig.tof, rig.tof, 0.003, 1);
    check_extrinsics(found->rig.tof_from_color, rig.tof_from_color, 2, 0.2);
    CHECK(found->rig.range_along_ray == rig.range_along_ray);
    CHECK(*found->depth_scale == Approx(1).margin(0.003));
    CHECK(found->color_noise_px == Approx(0.05).epsilon(0.2));
    CHECK(found->tof_noise_px == Approx(0.08).epsilon(0.2));
    // What it says of its own errors is about right.
    CHECK(std::abs(found->rig.color.pinhole.fx / rig.color.pinhole.fx - 1) <
          5 * found->sigma.color_focal);
    CHECK((found->rig.tof_from_color.T - rig.tof_from_color.T).norm() <
          8 * found->sigma.translation_m);
    const Assessment assessment = assess(*found, board, views, TimingFit{});
    // Of the wide view some parts are never reached.
    CHECK(assessment.verdict != Verdict::not_usable);
    if (rig.color.lens == Lens::brown_conrady)
        CHECK(assessment.verdict == Verdict::good);
}

TEST_CASE("a rig is found in pictures of boards with markers") {
    const Board marked = *parse_board(GENERATE("charuco:9x6:40", "aprilgrid:6x4:50"));
    INFO(to_text(marked));
    RigCalibration rig = narrow_rig();
    rig.tof = {{410, 412, 226, 168, 448, 344}, Lens::brown_conrady, {-0.05, 0.02, 0, 0.0005}};
    SimulatedBoards world(rig, marked);
    std::vector<BoardView> views;
    std::size_t found_in_both = 0;
    for (const Pose &pose : world.rests(20)) {
        const BoardMotion rest = [&](double) { return pose; };
        const SimulatedBoards::TofFrame tof = world.tof(rest, 0);
        views.push_back({fmt::format("view {}", views.size()),
                         find_board(marked, world.image(rest, 0)),
                         find_board(marked, to_luma(tof.amplitude)), tof.depth});
        found_in_both += !views.back().color.empty() && !views.back().tof.empty();
    }
    CHECK(found_in_both >= 12);
    const auto found = fit_rig(marked, views, rig.color.pinhole, rig.tof.pinhole, {});
    INFO((found ? "" : found.error().message));
    REQUIRE(found);
    check_intrinsics(found->rig.color, rig.color, 0.003, 1);
    check_intrinsics(found->rig.tof, rig.tof, 0.003, 1);
    check_extrinsics(found->rig.tof_from_color, rig.tof_from_color, 2, 0.2);
    CHECK(*found->depth_scale == Approx(1).margin(0.003));
}

TEST_CASE("the lens of one's own choice is fitted") {
    const RigCalibration rig = narrow_rig();
    SimulatedBoards world(rig, board);
    const auto found = fit(rig, look(world, 16), {Lens::kannala_brandt, {}, {}});
    REQUIRE(found);
    CHECK(found->rig.color.lens == Lens::kannala_brandt);
    CHECK(found->rig.tof.lens == Lens::brown_conrady);
}

TEST_CASE("without amplitude the TOF camera is found by the depth on the boards") {
    RigCalibration rig = narrow_rig();
    const bool has_lens = GENERATE(false, true);
    rig.range_along_ray = has_lens;
    if (!has_lens) {
        rig.tof.lens = Lens::pinhole;
        rig.tof.distortion = {};
    }
    SimulatedBoards world(rig, board);
    auto views = look(world, 24);
    for (BoardView &view : views)
        view.tof = {};
    const auto found = fit_rig_by_depth(board, views, rig.color.pinhole, rig.tof.pinhole, {});
    REQUIRE(found);
    CHECK(found->rig.tof.lens == rig.tof.lens);
    check_intrinsics(found->rig.tof, rig.tof, 0.003, 2);
    check_extrinsics(found->rig.tof_from_color, rig.tof_from_color, 2, 0.5);
    CHECK(found->rig.range_along_ray == rig.range_along_ray);
    SECTION("and better where its intrinsics are known") {
        const auto better =
            fit_rig_by_depth(board, views, rig.color.pinhole, rig.tof.pinhole, {{}, {}, rig.tof});
        REQUIRE(better);
        CHECK(better->rig.tof == rig.tof);
        check_extrinsics(better->rig.tof_from_color, rig.tof_from_color, 3, 0.3);
    }
}

namespace {

struct Moving {
    std::vector<MovingImage> images;
    std::vector<MovingDepth> maps;
};

Moving wave(SimulatedBoards &world, bool has_amplitude) {
    Moving moving;
    for (int k = 0; k < 60; ++k) {
        const double t = k / 30.0, t_map = t + 0.004;
        moving.images.push_back({t, world.corners_in_image(SimulatedBoards::wave, t)});
        moving.maps.push_back(
            {t_map, has_amplitude ? world.corners_in_tof(SimulatedBoards::wave, t_map) : Corners{},
             world.depth(SimulatedBoards::wave, t_map)});
    }
    return moving;
}

} // namespace

TEST_CASE("a moving board tells the delay and the read-out time") {
    struct Times {
        double delay_s, readout_s;
        bool has_amplitude;
    };
    const Times times =
        GENERATE(Times{-0.017, 0.022, true}, Times{0.045, 0, true}, Times{0.03, 0.03, false});
    RigCalibration rig = narrow_rig();
    rig.readout_s = times.readout_s;
    rig.tof_delay_s = times.delay_s;
    SimulatedBoards world(rig, board);
    const Moving moving = wave(world, times.has_amplitude);
    const auto timing = fit_timing(board, moving.images, moving.maps, rig);
    REQUIRE(timing);
    CHECK(1000 * timing->tof_delay_s == Approx(1000 * rig.tof_delay_s).margin(2));
    CHECK(1000 * timing->readout_s == Approx(1000 * rig.readout_s).margin(2));
    CHECK(timing->readout_sigma_s < 0.001);
}

TEST_CASE("a board that is not moved tells no times, nor one that is seen too seldom") {
    const RigCalibration rig = narrow_rig();
    SimulatedBoards world(rig, board);
    Moving moving = wave(world, false);
    std::vector<MovingImage> still = moving.images;
    for (MovingImage &image : still)
        image.corners = moving.images[0].corners;
    CHECK(mentions(fit_timing(board, still, moving.maps, rig).error().message, "moved by only"));
    still.resize(10);
    CHECK(mentions(fit_timing(board, still, moving.maps, rig).error().message, "10 of 10 images"));
    moving.maps.resize(10);
    CHECK(mentions(fit_timing(board, moving.images, moving.maps, rig).error().message,
                   "depth maps while"));
}

TEST_CASE("views that do not tell a calibration are refused with what they lack") {
    const RigCalibration rig = narrow_rig();
    SimulatedBoards world(rig, board);
    SECTION("too few") {
        CHECK(mentions(fit(rig, look(world, 4)).error().message,
                       "colour camera: the board was found in"));
    }
    SECTION("all from one angle") {
        CHECK(mentions(fit(rig, look(world, 12, 0.02)).error().message, "nearly the same angle"));
    }
    SECTION("of which the TOF camera sees none") {
        auto views = look(world, 12);
        for (BoardView &view : views)
            view.tof = {};
        CHECK(mentions(fit(rig, views).error().message, "TOF camera: the board was found in 0"));
        for (BoardView &view : views)
            for (std::uint16_t &pixel : view.depth.pixels())
                pixel = 0;
        CHECK(mentions(
            fit_rig_by_depth(board, views, rig.color.pinhole, rig.tof.pinhole, {}).error().message,
            "does not see the board"));
    }
    SECTION("whose files are mixed up") {
        auto views = look(world, 20);
        for (std::size_t k = 0; k + 1 < views.size(); ++k)
            std::swap(views[k].tof, views[k + 1].tof);
        CHECK(mentions(fit(rig, views).error().message, "mixed up"));
    }
}

TEST_CASE("a view whose board moved in between has no say") {
    const RigCalibration rig = narrow_rig();
    SimulatedBoards world(rig, board);
    auto views = look(world, 24);
    std::size_t swapped = 0;
    for (std::size_t k = 0; k < views.size() && swapped == 0; ++k)
        for (std::size_t i = 0; i < k && swapped == 0; ++i)
            if (!views[i].tof.empty() && !views[k].tof.empty() && !views[i].color.empty() &&
                !views[k].color.empty()) {
                std::swap(views[i].tof, views[k].tof);
                swapped = k;
            }
    REQUIRE(swapped > 0);
    const auto found = fit(rig, views);
    REQUIRE(found);
    CHECK(!found->used[swapped]);
    check_extrinsics(found->rig.tof_from_color, rig.tof_from_color, 2, 0.2);
}

TEST_CASE("a board that is larger than it is said to be is told by its depth") {
    const RigCalibration rig = narrow_rig();
    SimulatedBoards world(rig, board);
    world.depth_scale = 1.1;
    const auto views = look(world, 20);
    const auto found = fit(rig, views);
    REQUIRE(found);
    CHECK(*found->depth_scale == Approx(1.1).epsilon(0.005));
    const Assessment assessment = assess(*found, board, views, {});
    CHECK(assessment.verdict == Verdict::not_usable);
    CHECK(mentions(fmt::format("{}", fmt::join(assessment.reasons, "\n")),
                   "a side of the board has 49."));
}
