// SPDX-License-Identifier: Apache-2.0
#include "tests/simulated_boards.hpp"

#include <algorithm>
#include <cmath>

namespace afterglow {
namespace {

constexpr int side_px = 40;    ///< of the pattern
constexpr int samples = 3;     ///< of a pixel, in each direction
constexpr double wall_m = 2.5; ///< behind the board
constexpr double grey = 100;   ///< of the wall
constexpr double black = 35;
constexpr double white = 215;

std::uint16_t clamped(double value, double most) {
    return static_cast<std::uint16_t>(std::clamp(value + 0.5, 0.0, most));
}

} // namespace

RigCalibration narrow_rig() {
    RigCalibration rig;
    rig.color = {
        {520, 522, 316, 243, 640, 480}, Lens::brown_conrady, {-0.12, 0.06, 0.001, -0.0007, -0.01}};
    rig.tof = {{205, 206, 113, 84, 224, 172}, Lens::brown_conrady, {-0.05, 0.02, 0, 0.0005}};
    rig.tof_from_color = {rotation({0.02, -0.03, 0.01}), {0.025, 0.003, -0.004}};
    return rig;
}

SimulatedBoards::Rays::Rays(const CameraModel &model)
    : camera(model), x(model.pinhole.width + 1, model.pinhole.height + 1),
      y(model.pinhole.width + 1, model.pinhole.height + 1) {
    for (int v = 0; v < x.height(); ++v) {
        for (int u = 0; u < x.width(); ++u) {
            const auto ray = camera.ray(u - 0.5, v - 0.5).value_or(Eigen::Vector2d(50, 50));
            x(u, v) = static_cast<float>(ray.x());
            y(u, v) = static_cast<float>(ray.y());
        }
    }
}

/// (u, v) from the corner of the top left pixel.
Eigen::Vector2d SimulatedBoards::Rays::at(double u, double v) const {
    const int i = static_cast<int>(u), k = static_cast<int>(v);
    const double a = u - i, b = v - k;
    const auto blend = [&](const Image<float> &of) {
        return (1 - b) * ((1 - a) * of(i, k) + a * of(i + 1, k)) +
               b * ((1 - a) * of(i, k + 1) + a * of(i + 1, k + 1));
    };
    return {blend(x), blend(y)};
}

SimulatedBoards::SimulatedBoards(const RigCalibration &rig, const Board &board)
    : rig_(rig), board_(board), pattern_(draw_board(board, side_px)), color_(rig.color),
      tof_(rig.tof) {}

double SimulatedBoards::shade(const Pose &pose, const Eigen::Vector2d &ray) const {
    const Eigen::Vector3d d(ray.x(), ray.y(), 1), normal = pose.R.col(2);
    const double z = normal.dot(pose.T) / normal.dot(d);
    if (!(z > 0))
        return grey;
    const Eigen::Vector3d place = pose.R.transpose() * (z * d - pose.T);
    const int u = static_cast<int>(std::floor((place.x() / board_.side_m + 1) * side_px));
    const int v = static_cast<int>(std::floor((place.y() / board_.side_m + 1) * side_px));
    if (!pattern_.view().contains(u, v))
        return grey;
    return pattern_(u, v) > 127 ? white : black;
}

Luma SimulatedBoards::see(const Rays &rays, const RowPose &pose) const {
    Luma picture(rays.camera.pinhole.width, rays.camera.pinhole.height);
    const Eigen::Vector3d centre(board_.size_m().x() / 2, board_.size_m().y() / 2, 0);
    const double radius = centre.norm() + 2 * board_.side_m;
    for (int v = 0; v < picture.height(); ++v) {
        const Pose at = pose(static_cast<double>(v) / picture.height() - 0.5);
        for (int u = 0; u < picture.width(); ++u) {
            // Far from the board, as its middle is seen, there is only the wall.
            const Eigen::Vector3d middle = at * centre;
            const Eigen::Vector2d ray = rays.at(u + 0.5, v + 0.5);
            if ((ray - middle.head<2>() / middle.z()).norm() > radius / (middle.z() - radius)) {
                picture(u, v) = static_cast<std::uint8_t>(grey);
                continue;
            }
            double sum = 0;
            for (int i = 0; i < samples * samples; ++i)
                sum += shade(at, rays.at(u + (i % samples + 0.5) / samples,
                                         v + (i / samples + 0.5) / samples));
            picture(u, v) = static_cast<std::uint8_t>(sum / (samples * samples) + 0.5);
        }
    }
    return picture;
}

Luma SimulatedBoards::image(const BoardMotion &motion, double t_s) {
    Luma luma = see(color_, [&](double row) { return motion(t_s + row * rig_.readout_s); });
    std::normal_distribution<double> noise(0, luma_noise);
    for (std::uint8_t &pixel : luma.pixels())
        pixel = static_cast<std::uint8_t>(clamped(pixel + noise(random_), 255));
    return luma;
}

DepthMap SimulatedBoards::depth(const BoardMotion &motion, double t_s) {
    const Pose pose = rig_.tof_from_color * motion(t_s + rig_.tof_delay_s);
    const Eigen::Vector2d end = board_.size_m() + Eigen::Vector2d::Constant(board_.side_m);
    const Eigen::Vector3d normal = pose.R.col(2);
    std::normal_distribution<double> error(0, depth_noise_m);
    DepthMap depth(rig_.tof.pinhole.width, rig_.tof.pinhole.height);
    for (int v = 0; v < depth.height(); ++v) {
        for (int u = 0; u < depth.width(); ++u) {
            const Eigen::Vector2d ray = tof_.at(u + 0.5, v + 0.5);
            const Eigen::Vector3d d(ray.x(), ray.y(), 1);
            const double on_board = normal.dot(pose.T) / normal.dot(d);
            const Eigen::Vector3d place = pose.R.transpose() * (on_board * d - pose.T);
            const bool hit = on_board > 0 && place.x() > -board_.side_m &&
                             place.y() > -board_.side_m && place.x() < end.x() &&
                             place.y() < end.y();
            const double z = hit ? on_board : wall_m;
            const double range = rig_.range_along_ray ? z * d.norm() : z;
            depth(u, v) = clamped(1000 * (depth_scale * range + error(random_)), 65535);
        }
    }
    return depth;
}

SimulatedBoards::TofFrame SimulatedBoards::tof(const BoardMotion &motion, double t_s) {
    const Pose pose = rig_.tof_from_color * motion(t_s + rig_.tof_delay_s);
    const Luma luma = see(tof_, [&](double) { return pose; });
    TofFrame frame{depth(motion, t_s), Image<std::uint16_t>(luma.width(), luma.height())};
    std::normal_distribution<double> error(0, luma_noise);
    for (std::size_t i = 0; i < luma.pixels().size(); ++i) {
        const double z = std::max<double>(frame.depth.pixels()[i], 100) / 1000;
        frame.amplitude.pixels()[i] =
            clamped((luma.pixels()[i] + error(random_)) * 8 / (z * z), 65535);
    }
    return frame;
}

/// Each corner at the time of its row, which two rounds find.
Corners SimulatedBoards::project(const CameraModel &camera, const RowPose &pose, double noise_px) {
    Corners corners;
    if (!sees_whole(camera, pose(0)))
        return corners;
    std::normal_distribution<double> noise(0, noise_px);
    const auto places = board_.corners();
    for (std::size_t i = 0; i < places.size(); ++i) {
        Eigen::Vector2d at(0, camera.pinhole.height / 2.0);
        for (int round = 0; round < 3; ++round)
            at = camera.project(pose(at.y() / camera.pinhole.height - 0.5) *
                                Eigen::Vector3d(places[i].x(), places[i].y(), 0));
        corners.numbers.push_back(static_cast<int>(i));
        // One by one: compilers differ in the order of a call's arguments.
        const double v = at.y() + noise(random_);
        corners.pixels.emplace_back(at.x() + noise(random_), v);
    }
    return corners;
}

Corners SimulatedBoards::corners_in_image(const BoardMotion &motion, double t_s) {
    return project(
        rig_.color, [&](double row) { return motion(t_s + row * rig_.readout_s); }, color_noise_px);
}

Corners SimulatedBoards::corners_in_tof(const BoardMotion &motion, double t_s) {
    const Pose pose = rig_.tof_from_color * motion(t_s + rig_.tof_delay_s);
    return project(
        rig_.tof, [&](double) { return pose; }, tof_noise_px);
}

bool SimulatedBoards::sees_whole(const CameraModel &camera, const Pose &pose) const {
    const auto places = board_.corners();
    return std::all_of(places.begin(), places.end(), [&](const Eigen::Vector2d &place) {
        const Eigen::Vector3d X = pose * Eigen::Vector3d(place.x(), place.y(), 0);
        if (X.z() < 0.1)
            return false;
        const Eigen::Vector2d at = camera.project(X);
        const auto ray = camera.ray(at.x(), at.y());
        return at.x() > 6 && at.y() > 6 && at.x() < camera.pinhole.width - 7 &&
               at.y() < camera.pinhole.height - 7 && ray &&
               (*ray - X.head<2>() / X.z()).norm() < 1e-3;
    });
}

std::vector<Pose> SimulatedBoards::rests(int count, double tilt) {
    std::uniform_real_distribution<double> share(0, 1), turn(-1, 1);
    const Eigen::Vector3d centre(board_.size_m().x() / 2, board_.size_m().y() / 2, 0);
    std::vector<Pose> poses;
    while (static_cast<int>(poses.size()) < count) {
        const bool for_tof = poses.size() % 2 == 1;
        const CameraModel &camera = for_tof ? rig_.tof : rig_.color;
        const double v = share(random_) * camera.pinhole.height;
        const auto ray = camera.ray(share(random_) * camera.pinhole.width, v);
        const double distance = board_.size_m().x() * (1.2 + 1.3 * share(random_));
        Pose pose{rotation({tilt * turn(random_), tilt * turn(random_), 0.3 * turn(random_)}), {}};
        if (!ray)
            continue;
        pose.T = distance * Eigen::Vector3d(ray->x(), ray->y(), 1).normalized() - pose.R * centre;
        if (sees_whole(camera, pose))
            poses.push_back(for_tof ? rig_.tof_from_color.inverse() * pose : pose);
    }
    return poses;
}

Pose SimulatedBoards::wave(double t_s) {
    Pose pose{rotation({0.25 * std::sin(2.3 * t_s), 0.35 * std::sin(3.1 * t_s + 1),
                        0.15 * std::sin(1.7 * t_s)}),
              {}};
    pose.T =
        Eigen::Vector3d(-0.15 + 0.13 * std::sin(2.9 * t_s), -0.1 + 0.09 * std::sin(3.7 * t_s + 2),
                        0.75 + 0.1 * std::sin(2.1 * t_s));
    return pose;
}

} // namespace afterglow
