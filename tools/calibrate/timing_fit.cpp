// SPDX-License-Identifier: Apache-2.0
#include "tools/calibrate/timing_fit.hpp"

#include "core/base/median.hpp"
#include "tools/calibrate/board_depth.hpp"
#include "tools/calibrate/board_motion.hpp"
#include "tools/calibrate/camera_fit.hpp"
#include "tools/calibrate/least_squares.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <vector>

namespace afterglow {
namespace {

constexpr std::size_t fewest_images = 30;
constexpr int fewest_maps = 15;
constexpr double least_speed_px_s = 40;
/// The board's motion is not known where it was not seen for longer than this.
constexpr double longest_gap_s = 0.12;
/// How much the board's speed may change from one control point of its motion to the next, m and
/// rad: 5 m/s^2. Where the board is seen, its corners weigh far more.
constexpr double expected_bend = 0.05;
constexpr int readout_at = 0;
constexpr int motion_at = 1;

struct SeenPose {
    double t_s;
    Pose pose;
};

/// How fast the board goes through the images.
double speed(std::span<const MovingImage> images) {
    std::vector<double> speeds;
    for (std::size_t k = 1; k < images.size(); ++k) {
        const Corners &a = images[k - 1].corners, &b = images[k].corners;
        for (std::size_t i = 0; i < a.size(); ++i) {
            const auto same = std::find(b.numbers.begin(), b.numbers.end(), a.numbers[i]);
            if (same != b.numbers.end())
                speeds.push_back(
                    (b.pixels[static_cast<std::size_t>(same - b.numbers.begin())] - a.pixels[i])
                        .norm() /
                    (images[k].t_s - images[k - 1].t_s));
        }
    }
    return speeds.empty() ? 0 : median(std::move(speeds));
}

/// The board as the images see it, row by row.
ResidualBlock image_block(const std::vector<Eigen::Vector2d> &places, const MovingImage &image,
                          const CameraModel &camera, const BoardMotionSpline &motion,
                          double noise_px) {
    ResidualBlock block{{readout_at}, 2 * static_cast<int>(image.corners.size()), {}};
    const auto [first, last] =
        motion.controls(image.t_s - longest_readout_s / 2, image.t_s + longest_readout_s / 2);
    for (int i = 6 * first; i < 6 * (last + 1); ++i)
        block.parameters.push_back(motion.at() + i);
    block.evaluate = [&places, &image, camera, motion, noise_px](const Eigen::VectorXd &x,
                                                                 Eigen::Ref<Eigen::VectorXd> r) {
        const double readout = std::clamp(x[readout_at], -longest_readout_s, longest_readout_s);
        for (std::size_t i = 0; i < image.corners.size(); ++i) {
            const Eigen::Vector2d &place =
                places[static_cast<std::size_t>(image.corners.numbers[i])];
            const Eigen::Vector2d &seen = image.corners.pixels[i];
            const double row = std::clamp(seen.y() / camera.pinhole.height - 0.5, -0.5, 0.5);
            const Eigen::Vector3d X = motion.pose(x, image.t_s + row * readout) *
                                      Eigen::Vector3d(place.x(), place.y(), 0);
            r.segment<2>(2 * static_cast<int>(i)) = (camera.project(X) - seen) / noise_px;
        }
    };
    return block;
}

/// A hand is smooth: this holds the motion where the board was not seen.
ResidualBlock bend_block(const BoardMotionSpline &motion, int control) {
    const int at = motion.at() + 6 * control;
    ResidualBlock block{{}, 6, {}};
    for (int i = 0; i < 18; ++i)
        block.parameters.push_back(at + i);
    block.evaluate = [at](const Eigen::VectorXd &x, Eigen::Ref<Eigen::VectorXd> r) {
        r = (x.segment<6>(at) - 2 * x.segment<6>(at + 6) + x.segment<6>(at + 12)) / expected_bend;
    };
    return block;
}

/// The motion, as the images tell it, and the read-out time found with it.
struct FoundMotion {
    BoardMotionSpline spline;
    Eigen::VectorXd x;
    double readout_s, sigma_s;

    Pose pose(double t_s) const { return spline.pose(x, t_s); }
};

FoundMotion find_motion(const std::vector<Eigen::Vector2d> &places,
                        std::span<const MovingImage> images, const std::vector<SeenPose> &poses,
                        const CameraModel &camera) {
    const BoardMotionSpline motion(poses.front().t_s - longest_readout_s,
                                   poses.back().t_s + longest_readout_s,
                                   poses[poses.size() / 2].pose.R, motion_at);
    Eigen::VectorXd x = Eigen::VectorXd::Zero(motion_at + 6 * motion.control_points());
    std::vector<ResidualBlock> bends;
    for (int i = 0; i < motion.control_points(); ++i) {
        const double t = motion.time_of(i);
        const auto nearest =
            std::min_element(poses.begin(), poses.end(), [&](const auto &a, const auto &b) {
                return std::abs(a.t_s - t) < std::abs(b.t_s - t);
            });
        motion.start_at(i, nearest->pose, x);
        if (i + 2 < motion.control_points())
            bends.push_back(bend_block(motion, i));
    }
    double noise = 2; // pixels
    LeastSquaresFit fit;
    for (int round = 0; round < 2; ++round) {
        std::vector<ResidualBlock> seen;
        for (const MovingImage &image : images)
            if (!image.corners.empty())
                seen.push_back(image_block(places, image, camera, motion, noise));
        std::vector<ResidualBlock> blocks = seen;
        blocks.insert(blocks.end(), bends.begin(), bends.end());
        fit = least_squares(x, blocks, 15);
        x = fit.x;
        noise = std::max(noise * noise_of(x, seen), least_noise_px);
    }
    return {motion, x, x[readout_at], fit.sigma[readout_at]};
}

/// Whether the board was seen all the time around a map, wherever its clock is.
bool is_followed(const std::vector<SeenPose> &poses, double t_s) {
    const double begin = t_s - largest_delay_s, end = t_s + largest_delay_s;
    if (poses.front().t_s > begin || poses.back().t_s < end)
        return false;
    for (std::size_t k = 1; k < poses.size(); ++k)
        if (poses[k].t_s > begin && poses[k - 1].t_s < end &&
            poses[k].t_s - poses[k - 1].t_s > longest_gap_s)
            return false;
    return true;
}

/// What the map of a moving board says of the delay, which is the only unknown.
ResidualBlock map_block(const Board &board, const std::vector<Eigen::Vector2d> &places,
                        const MovingDepth &map, const FoundMotion &motion,
                        const RigCalibration &rig) {
    constexpr double gate_m = 0.15, noise_px = 0.3, noise_m = 0.01;
    const auto board_to_tof = [&motion, &rig, t = map.t_s](double delay) {
        return rig.tof_from_color *
               motion.pose(t + std::clamp(delay, -largest_delay_s, largest_delay_s));
    };
    ResidualBlock block{{0}, 0, {}};
    if (!map.corners.empty()) {
        block.count = 2 * static_cast<int>(map.corners.size());
        block.evaluate = [=, &places, &map, &rig](const Eigen::VectorXd &x,
                                                  Eigen::Ref<Eigen::VectorXd> r) {
            corner_residuals(places, map.corners, rig.tof, board_to_tof(x[0]), noise_px, r);
        };
        return block;
    }
    auto readings =
        readings_on_board(board, board_to_tof(0), rig.tof, rig.range_along_ray, map.depth, gate_m);
    block.count = static_cast<int>(readings.size());
    block.evaluate = [=, &rig, readings = std::move(readings)](const Eigen::VectorXd &x,
                                                               Eigen::Ref<Eigen::VectorXd> r) {
        plane_residuals(readings, rig.tof, rig.range_along_ray, board_to_tof(x[0]), noise_m, 1, r);
    };
    return block;
}

/// The delay with the smallest sum: there may be more than one that is smallest around.
double coarse_delay(const std::vector<ResidualBlock> &blocks) {
    double best = 0, smallest = std::numeric_limits<double>::infinity();
    for (double delay = -largest_delay_s; delay <= largest_delay_s; delay += 0.005) {
        const double cost = least_squares(Eigen::VectorXd::Constant(1, delay), blocks, 0).cost;
        if (cost < smallest) {
            smallest = cost;
            best = delay;
        }
    }
    return best;
}

} // namespace

Result<TimingFit> fit_timing(const Board &board, std::span<const MovingImage> images,
                             std::span<const MovingDepth> maps, const RigCalibration &rig) {
    const std::vector<Eigen::Vector2d> places = board.corners();
    std::vector<SeenPose> poses;
    for (const MovingImage &image : images)
        if (const auto pose = board_pose(board, image.corners, rig.color))
            poses.push_back({image.t_s, *pose});
    if (poses.size() < fewest_images)
        return Error{fmt::format("the moving board was found in {} of {} images; {} are the least: "
                                 "move it more slowly, in good light, wholly in the picture",
                                 poses.size(), images.size(), fewest_images)};
    TimingFit timing;
    timing.images = static_cast<int>(poses.size());
    timing.speed_px_s = speed(images);
    if (timing.speed_px_s < least_speed_px_s)
        return Error{fmt::format("the board moved by only {:.0f} pixels a second; from {:.0f} on "
                                 "the times can be told",
                                 timing.speed_px_s, least_speed_px_s)};
    const FoundMotion motion = find_motion(places, images, poses, rig.color);
    timing.readout_s = motion.readout_s;
    timing.readout_sigma_s = motion.sigma_s;

    std::vector<ResidualBlock> blocks;
    for (const MovingDepth &map : maps) {
        if (!is_followed(poses, map.t_s))
            continue;
        ResidualBlock block = map_block(board, places, map, motion, rig);
        if (block.count > 0)
            blocks.push_back(std::move(block));
    }
    timing.maps = static_cast<int>(blocks.size());
    if (timing.maps < fewest_maps)
        return Error{fmt::format("the moving board was seen in {} depth maps while the images "
                                 "showed it as well; {} are the least: move it where both cameras "
                                 "see it",
                                 timing.maps, fewest_maps)};
    const LeastSquaresFit fit =
        least_squares(Eigen::VectorXd::Constant(1, coarse_delay(blocks)), blocks);
    timing.tof_delay_s = fit.x[0];
    timing.tof_delay_sigma_s = fit.sigma[0] * noise_of(fit.x, blocks);
    if (std::abs(timing.tof_delay_s) > largest_delay_s - 0.005)
        return Error{fmt::format("the clocks of the cameras are more than {:.0f} ms apart, or the "
                                 "recording of the moving board has mixed-up files",
                                 1000 * largest_delay_s)};
    return timing;
}

} // namespace afterglow
