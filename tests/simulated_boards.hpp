// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "core/base/image.hpp"
#include "core/base/rig_calibration.hpp"
#include "tools/calibrate/board.hpp"
#include "tools/calibrate/find_board.hpp"

#include <Eigen/Core>

#include <cstdint>
#include <functional>
#include <random>
#include <vector>

namespace afterglow {

/// Two cameras like many: 640x480 and 224x172, 25 mm apart and turned by two degrees.
RigCalibration narrow_rig();

/// Where a board is in the colour camera's frame, seconds.
using BoardMotion = std::function<Pose(double t_s)>;

/// A rig before a board and a grey wall: what each camera gives, with noise, and nothing but the
/// truth. Rows of an image are exposed one after the other; depth maps at their own time.
class SimulatedBoards {
public:
    SimulatedBoards(const RigCalibration &rig, const Board &board);

    double luma_noise = 1.5;
    double color_noise_px = 0.05; ///< of corners
    double tof_noise_px = 0.08;
    double depth_noise_m = 0.003;
    double depth_scale = 1; ///< what the TOF camera measures by what is

    /// An image that is stamped `t_s`.
    Luma image(const BoardMotion &motion, double t_s);
    struct TofFrame {
        DepthMap depth;
        Image<std::uint16_t> amplitude;
    };
    /// What is stamped `t_s` by the TOF camera: exposed tof_delay_s later.
    TofFrame tof(const BoardMotion &motion, double t_s);

    /// What a detector would find in them, with its noise; empty where the board is not whole in
    /// the picture. Much faster than to draw them.
    Corners corners_in_image(const BoardMotion &motion, double t_s);
    Corners corners_in_tof(const BoardMotion &motion, double t_s);
    /// The depth of tof() alone.
    DepthMap depth(const BoardMotion &motion, double t_s);

    /// Poses of boards at rest, near and far and tilted up to `tilt` radians: in turn all over the
    /// colour camera's view and the TOF camera's, in which they are whole. Reproducible.
    std::vector<Pose> rests(int count, double tilt = 0.7);
    /// A board that is waved before the cameras for as long as one likes.
    static Pose wave(double t_s);

private:
    /// A camera's rays at the corners of its pixels, where they are smooth.
    struct Rays {
        explicit Rays(const CameraModel &camera);
        Eigen::Vector2d at(double u, double v) const;
        CameraModel camera;
        Image<float> x, y;
    };
    using RowPose = std::function<Pose(double row_share)>; ///< board to camera; -0.5 to 0.5
    Luma see(const Rays &rays, const RowPose &pose) const;
    bool sees_whole(const CameraModel &camera, const Pose &board_to_camera) const;
    Corners project(const CameraModel &camera, const RowPose &pose, double noise_px);
    double shade(const Pose &pose, const Eigen::Vector2d &ray) const;

    RigCalibration rig_;
    Board board_;
    Luma pattern_;
    Rays color_, tof_;
    std::mt19937 random_{1};
};

} // namespace afterglow
