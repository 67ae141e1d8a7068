// SPDX-License-Identifier: Apache-2.0
#include "tools/calibrate/rig_fit.hpp"

#include "tools/calibrate/board_depth.hpp"
#include "tools/calibrate/least_squares.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

namespace afterglow {
namespace {

/// Two views agree about where one camera is beside the other within this.
constexpr double agreeing_m = 0.05;
constexpr double agreeing_rad = 0.06;

bool agree(const Pose &a, const Pose &b) {
    const Pose between = a * b.inverse();
    return between.angle() < agreeing_rad && (a.T - b.T).norm() < agreeing_m;
}

std::vector<std::size_t> those(std::span<const BoardView> views, Corners BoardView::*corners) {
    std::vector<std::size_t> seen;
    for (std::size_t k = 0; k < views.size(); ++k)
        if (!(views[k].*corners).empty())
            seen.push_back(k);
    return seen;
}

Result<CameraFit> fit_one(const Board &board, std::span<const BoardView> views,
                          Corners BoardView::*corners, const char *name, const Intrinsics &size,
                          const std::optional<Lens> &lens) {
    std::vector<Corners> seen;
    for (const BoardView &view : views)
        if (!(view.*corners).empty())
            seen.push_back(view.*corners);
    Result<CameraFit> fit = fit_camera(board, seen, size.width, size.height, lens);
    if (!fit)
        return Error{fmt::format("{} camera: {}", name, fit.error().message)};
    return fit;
}

/// The problem of both cameras: x = (colour camera, TOF camera, tof_from_color, a twist for each
/// view).
struct Problem {
    const Board &board;
    std::span<const BoardView> views;
    std::vector<Eigen::Vector2d> places;
    CameraUnknowns color, tof;
    std::vector<bool> used;

    int pose_at(std::size_t view) const {
        return tof.extrinsics_at + 6 + 6 * static_cast<int>(view);
    }
    std::vector<ResidualBlock> blocks_of(Corners BoardView::*corners, const CameraUnknowns &camera,
                                         double noise_px) const {
        std::vector<ResidualBlock> blocks;
        for (std::size_t k = 0; k < views.size(); ++k)
            if (used[k] && !(views[k].*corners).empty())
                blocks.push_back(
                    corner_block(places, views[k].*corners, camera, pose_at(k), noise_px));
        return blocks;
    }
};

/// The pose that most views agree with.
Pose most_agreed(const std::vector<Pose> &candidates) {
    const auto votes = [&](const Pose &pose) {
        return std::count_if(candidates.begin(), candidates.end(),
                             [&](const Pose &other) { return agree(pose, other); });
    };
    return *std::max_element(candidates.begin(), candidates.end(),
                             [&](const auto &a, const auto &b) { return votes(a) < votes(b); });
}

std::string names_of(std::span<const BoardView> views, const std::vector<std::size_t> &which) {
    std::string names;
    for (std::size_t i = 0; i < which.size() && i < 5; ++i)
        names += (i > 0 ? ", " : "") + views[which[i]].name;
    return which.size() > 5 ? names + " and others" : names;
}

RigSigma sigma_of(const Problem &problem, const LeastSquaresFit &fit) {
    const auto worst = [&](int first, int count) {
        return fit.sigma.segment(first, count).maxCoeff();
    };
    RigSigma sigma;
    sigma.color_focal = worst(problem.color.at, 2) / fit.x[problem.color.at];
    sigma.color_center_px = worst(problem.color.at + 2, 2);
    sigma.tof_focal = worst(problem.tof.at, 2) / fit.x[problem.tof.at];
    sigma.tof_center_px = worst(problem.tof.at + 2, 2);
    sigma.translation_m = worst(problem.tof.extrinsics_at, 3);
    sigma.rotation_rad = worst(problem.tof.extrinsics_at + 3, 3);
    return sigma;
}

} // namespace

Result<RigFit> fit_rig(const Board &board, std::span<const BoardView> views,
                       const Intrinsics &color_size, const Intrinsics &tof_size,
                       const RigWishes &wishes) {
    Result<CameraFit> color =
        fit_one(board, views, &BoardView::color, "colour", color_size, wishes.color_lens);
    if (!color)
        return color.error();
    Result<CameraFit> tof =
        fit_one(board, views, &BoardView::tof, "TOF", tof_size, wishes.tof_lens);
    if (!tof)
        return tof.error();

    // Where both see the board each view says where the cameras are.
    const std::vector<std::size_t> in_color = those(views, &BoardView::color);
    const std::vector<std::size_t> in_tof = those(views, &BoardView::tof);
    std::vector<std::size_t> in_both;
    std::vector<Pose> candidates, from_color(views.size()), from_tof(views.size());
    for (std::size_t i = 0; i < in_color.size(); ++i)
        from_color[in_color[i]] = color->board_to_camera[i];
    for (std::size_t i = 0; i < in_tof.size(); ++i)
        from_tof[in_tof[i]] = tof->board_to_camera[i];
    for (std::size_t k = 0; k < views.size(); ++k) {
        if (views[k].color.empty() || views[k].tof.empty())
            continue;
        in_both.push_back(k);
        candidates.push_back(from_tof[k] * from_color[k].inverse());
    }
    if (in_both.size() < 4)
        return Error{fmt::format("both cameras see the board in {} of {} views; 4 are the least, "
                                 "and 15 a good number: where the TOF camera does not see it, hold "
                                 "it nearer, or print a board with larger squares",
                                 in_both.size(), views.size())};
    const Pose extrinsics = most_agreed(candidates);
    std::vector<std::size_t> odd;
    for (std::size_t i = 0; i < candidates.size(); ++i)
        if (!agree(candidates[i], extrinsics))
            odd.push_back(in_both[i]);
    if (2 * odd.size() > in_both.size())
        return Error{fmt::format("the cameras do not see the same boards: {} of {} views ({}) "
                                 "contradict the others about where the TOF camera is. The board "
                                 "moved between image and depth map, or files are mixed up",
                                 odd.size(), in_both.size(), names_of(views, odd))};

    Problem problem{board, views, board.corners(), {}, {}, std::vector<bool>(views.size(), false)};
    problem.color = {color->model, color_size.width, color_size.height};
    problem.tof = {tof->model,      tof_size.width,
                   tof_size.height, color->model.parameters(),
                   false,           color->model.parameters() + tof->model.parameters()};
    Eigen::VectorXd x(problem.pose_at(views.size()));
    x.head(color->model.parameters()) = to_parameters(color->camera, color->model);
    x.segment(problem.tof.at, tof->model.parameters()) = to_parameters(tof->camera, tof->model);
    x.segment<6>(problem.tof.extrinsics_at) = log(extrinsics);
    for (std::size_t k = 0; k < views.size(); ++k) {
        problem.used[k] = (!views[k].color.empty() || !views[k].tof.empty()) &&
                          std::find(odd.begin(), odd.end(), k) == odd.end();
        x.segment<6>(problem.pose_at(k)) =
            log(views[k].color.empty() ? extrinsics.inverse() * from_tof[k] : from_color[k]);
    }
    RigFit fit;
    double color_noise = 4 * color->noise_px, tof_noise = 4 * tof->noise_px;
    LeastSquaresFit solved;
    for (int round = 0; round < 3; ++round) {
        const auto color_blocks = problem.blocks_of(&BoardView::color, problem.color, color_noise);
        const auto tof_blocks = problem.blocks_of(&BoardView::tof, problem.tof, tof_noise);
        std::vector<ResidualBlock> blocks = color_blocks;
        blocks.insert(blocks.end(), tof_blocks.begin(), tof_blocks.end());
        solved = least_squares(x, blocks);
        x = solved.x;
        color_noise = std::max(color_noise * noise_of(x, color_blocks), least_noise_px);
        tof_noise = std::max(tof_noise * noise_of(x, tof_blocks), least_noise_px);
    }
    fit.rig.color = problem.color.camera(x);
    fit.rig.tof = problem.tof.camera(x);
    fit.rig.tof_from_color = problem.tof.from_color(x);
    fit.color_model = color->model;
    fit.tof_model = tof->model;
    fit.used = problem.used;
    fit.color_noise_px = color_noise;
    fit.tof_noise_px = tof_noise;
    fit.sigma = sigma_of(problem, solved);
    std::vector<SeenBoard> seen;
    for (std::size_t k = 0; k < views.size(); ++k) {
        fit.board_to_color.push_back(exp(Twist(x.segment<6>(problem.pose_at(k)))));
        if (problem.used[k])
            seen.push_back({&views[k].depth, fit.rig.tof_from_color * fit.board_to_color.back()});
    }
    if (const auto check = check_depth(board, seen, fit.rig.tof)) {
        fit.rig.range_along_ray = check->range_along_ray;
        fit.depth_scale = check->scale;
        fit.depth_noise_m = check->noise_m;
    }
    return fit;
}

} // namespace afterglow
