// SPDX-License-Identifier: Apache-2.0
#include "tools/calibrate/depth_fit.hpp"

#include "tools/calibrate/board_depth.hpp"
#include "tools/calibrate/least_squares.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <numbers>

namespace afterglow {
namespace {

/// Horizontal fields of view that are tried, degrees, where the TOF camera is not known.
constexpr std::array<double, 5> fields = {50, 60, 70, 80, 92};
/// How far from where a board is expected its readings are looked for, from coarse to fine.
constexpr std::array<double, 5> gates_m = {0.25, 0.12, 0.06, 0.05, 0.05};
constexpr std::size_t fewest_readings = 30; ///< of a view
constexpr int readings_to_search = 200;     ///< of a view, at most
constexpr int readings_to_fit = 1000;
constexpr std::size_t fewest_depth_views = 8;
constexpr double least_noise_m = 0.0002;

// x = (TOF camera, tof_from_color, scale)
struct Unknowns {
    CameraUnknowns tof;
    int scale_at;
};

Unknowns unknowns_of(const LensModel &lens, const Intrinsics &size, bool is_known) {
    const int extrinsics_at = lens.parameters();
    return {{lens, size.width, size.height, 0, is_known, extrinsics_at}, extrinsics_at + 6};
}

/// The lenses that a camera is fitted with, found as a pinhole.
std::vector<LensModel> lenses_to_try(const std::optional<Lens> &wanted) {
    const LensModel pinhole{}, brown_conrady{Lens::brown_conrady, 2},
        kannala_brandt{Lens::kannala_brandt, 4};
    if (!wanted)
        return {pinhole, brown_conrady};
    return {*wanted == Lens::pinhole         ? pinhole
            : *wanted == Lens::brown_conrady ? brown_conrady
                                             : kannala_brandt};
}

/// A camera of that lens that sees as a pinhole does.
CameraModel as_pinhole(CameraModel camera, Lens lens) {
    camera.lens = lens;
    if (lens == Lens::kannala_brandt) // the tangent's series
        camera.distortion = {1.0 / 3, 2.0 / 15, 17.0 / 315, 62.0 / 2835};
    return camera;
}

struct PlaneFit {
    LeastSquaresFit fit;
    double noise_m = 0;
    std::size_t views = 0;    ///< with depth on the board
    std::size_t readings = 0; ///< on all of them

    /// Schwarz's criterion, but for a constant: the least is the model that the readings speak for.
    double criterion(int parameters) const {
        const auto n = static_cast<double>(readings);
        return n * std::log(fit.cost) + parameters * std::log(n);
    }
    std::vector<bool> used;
};

ResidualBlock plane_block(std::vector<DepthReading> readings, const Unknowns &unknowns,
                          bool range_along_ray, bool scale_is_free, const Pose &board_to_color,
                          double noise_m) {
    ResidualBlock block{{}, static_cast<int>(readings.size()), {}};
    for (int i = unknowns.tof.is_known ? unknowns.tof.extrinsics_at : 0;
         i < unknowns.scale_at + (scale_is_free ? 1 : 0); ++i)
        block.parameters.push_back(i);
    block.evaluate = [readings = std::move(readings), unknowns, range_along_ray, board_to_color,
                      noise_m](const Eigen::VectorXd &x, Eigen::Ref<Eigen::VectorXd> r) {
        plane_residuals(readings, unknowns.tof.camera(x), range_along_ray,
                        unknowns.tof.from_color(x) * board_to_color, noise_m, x[unknowns.scale_at],
                        r);
    };
    return block;
}

/// Fits to the readings within `gate_m` of where x expects the boards.
PlaneFit fit_planes(const Board &board, std::span<const BoardView> views,
                    const std::vector<Pose> &board_to_color, const Unknowns &unknowns,
                    bool range_along_ray, bool scale_is_free, const Eigen::VectorXd &x,
                    double gate_m, double noise_m, int most_readings) {
    PlaneFit planes;
    std::vector<ResidualBlock> blocks;
    const CameraModel camera = unknowns.tof.camera(x);
    for (std::size_t k = 0; k < views.size(); ++k) {
        std::vector<DepthReading> readings;
        if (!views[k].color.empty())
            readings =
                readings_on_board(board, unknowns.tof.from_color(x) * board_to_color[k], camera,
                                  range_along_ray, views[k].depth, gate_m, most_readings);
        planes.used.push_back(readings.size() >= fewest_readings);
        if (planes.used.back()) {
            planes.readings += readings.size();
            blocks.push_back(plane_block(std::move(readings), unknowns, range_along_ray,
                                         scale_is_free, board_to_color[k], noise_m));
        }
    }
    planes.views = blocks.size();
    planes.fit = least_squares(x, blocks, 20);
    planes.noise_m = std::max(noise_m * noise_of(planes.fit.x, blocks), least_noise_m);
    return planes;
}

} // namespace

Result<RigFit> fit_rig_by_depth(const Board &board, std::span<const BoardView> views,
                                const Intrinsics &color_size, const Intrinsics &tof_size,
                                const RigWishes &wishes) {
    std::vector<Corners> seen;
    for (const BoardView &view : views)
        if (!view.color.empty())
            seen.push_back(view.color);
    const Result<CameraFit> color =
        fit_camera(board, seen, color_size.width, color_size.height, wishes.color_lens);
    if (!color)
        return Error{fmt::format("colour camera: {}", color.error().message)};
    std::vector<Pose> board_to_color(views.size());
    auto next = color->board_to_camera.begin();
    for (std::size_t k = 0; k < views.size(); ++k)
        if (!views[k].color.empty())
            board_to_color[k] = *next++;
    std::vector<CameraModel> guesses;
    if (wishes.tof_camera) {
        guesses.push_back(*wishes.tof_camera);
    } else {
        for (const double field : fields) {
            const double f = tof_size.width / 2.0 / std::tan(field * std::numbers::pi / 360);
            guesses.push_back({{f, f, (tof_size.width - 1) / 2.0, (tof_size.height - 1) / 2.0,
                                tof_size.width, tof_size.height}});
        }
    }
    LensModel lens;
    if (wishes.tof_camera)
        lens = {wishes.tof_camera->lens, wishes.tof_camera->lens == Lens::pinhole          ? 0
                                         : wishes.tof_camera->lens == Lens::kannala_brandt ? 4
                                                                                           : 8};
    Unknowns unknowns = unknowns_of(lens, tof_size, wishes.tof_camera.has_value());
    PlaneFit best;
    bool range_along_ray = false;
    for (const bool along_ray : {false, true}) {
        for (const CameraModel &guess : guesses) {
            Eigen::VectorXd x = Eigen::VectorXd::Zero(unknowns.scale_at + 1);
            x.head(lens.parameters()) = to_parameters(guess, lens);
            x[unknowns.scale_at] = 1;
            PlaneFit planes;
            double noise = gates_m.front() / 3;
            for (const double gate : gates_m) {
                planes = fit_planes(board, views, board_to_color, unknowns, along_ray, false, x,
                                    gate, noise, readings_to_search);
                noise = planes.noise_m;
                x = planes.fit.x;
                if (planes.views < fewest_depth_views || !(x[0] > 0.1 * tof_size.width))
                    break;
            }
            const bool found = planes.views >= fewest_depth_views && x[0] > 0.1 * tof_size.width;
            if (found && (best.views == 0 || planes.noise_m < best.noise_m)) {
                best = planes;
                range_along_ray = along_ray;
            }
        }
    }
    if (best.views == 0)
        return Error{fmt::format("the TOF camera does not see the board: fewer than {} of {} views "
                                 "have depth where it must be. Hold it where both cameras see it; "
                                 "if the TOF camera is far from the colour camera or turned away "
                                 "from it, it cannot be found",
                                 fewest_depth_views, views.size())};
    const PlaneFit found = best;
    const auto fit_all = [&](const Unknowns &what, const Eigen::VectorXd &x, bool scale_is_free) {
        return fit_planes(board, views, board_to_color, what, range_along_ray, scale_is_free, x,
                          gates_m.back(), found.noise_m, readings_to_fit);
    };
    if (wishes.tof_camera) {
        best = fit_all(unknowns, best.fit.x, false);
    } else {
        double least = std::numeric_limits<double>::infinity();
        for (const LensModel &model : lenses_to_try(wishes.tof_lens)) {
            const Unknowns with_lens = unknowns_of(model, tof_size, false);
            Eigen::VectorXd x(with_lens.scale_at + 1);
            x << to_parameters(
                as_pinhole(to_camera(found.fit.x, {}, tof_size.width, tof_size.height), model.lens),
                model),
                found.fit.x.tail(7);
            const PlaneFit planes = fit_all(with_lens, x, false);
            if (const double criterion = planes.criterion(model.parameters()); criterion < least) {
                least = criterion;
                best = planes;
                lens = model;
                unknowns = with_lens;
            }
        }
    }
    // How large the board would have to be.
    const PlaneFit scaled = fit_all(unknowns, best.fit.x, true);
    RigFit fit;
    const Eigen::VectorXd &x = best.fit.x;
    fit.rig.color = color->camera;
    fit.rig.tof = unknowns.tof.camera(x);
    fit.rig.tof_from_color = unknowns.tof.from_color(x);
    fit.rig.range_along_ray = range_along_ray;
    fit.color_model = color->model;
    fit.tof_model = lens;
    fit.board_to_color = board_to_color;
    fit.used = best.used;
    fit.color_noise_px = color->noise_px;
    fit.depth_noise_m = best.noise_m;
    fit.depth_scale = 1 / scaled.fit.x[unknowns.scale_at];
    fit.sigma.color_focal = color->focal_sigma;
    fit.sigma.color_center_px = color->center_sigma_px;
    fit.sigma.tof_focal = best.fit.sigma.head<2>().maxCoeff() / x[0];
    fit.sigma.tof_center_px = best.fit.sigma.segment<2>(2).maxCoeff();
    fit.sigma.translation_m = best.fit.sigma.segment<3>(unknowns.tof.extrinsics_at).maxCoeff();
    fit.sigma.rotation_rad = best.fit.sigma.segment<3>(unknowns.tof.extrinsics_at + 3).maxCoeff();
    return fit;
}

} // namespace afterglow
