// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "core/base/camera_model.hpp"
#include "core/base/rigid_motion.hpp"
#include "tools/calibrate/find_board.hpp"
#include "tools/calibrate/least_squares.hpp"

#include <Eigen/Core>

#include <span>
#include <string>
#include <vector>

namespace afterglow {

/// What is estimated of a lens: which model, and how many of its coefficients.
struct LensModel {
    Lens lens = Lens::pinhole;
    int coefficients = 0;

    int parameters() const { return 4 + coefficients; } ///< with fx fy cx cy
    bool operator==(const LensModel &) const = default;
};
std::string to_text(const LensModel &model); ///< "brown-conrady with 5 coefficients"

/// A camera as parameters of a least squares problem: fx fy cx cy, then the coefficients.
Eigen::VectorXd to_parameters(const CameraModel &camera, const LensModel &model);
CameraModel to_camera(const Eigen::Ref<const Eigen::VectorXd> &parameters, const LensModel &model,
                      int width, int height);

/// Where the parameters of a camera and its place stand in a problem. Poses are twists.
struct CameraUnknowns {
    LensModel model;
    int width = 0;
    int height = 0;
    int at = 0;             ///< of the camera's own parameters
    bool is_known = false;  ///< which are then not changed
    int extrinsics_at = -1; ///< takes points of the colour camera to this one; -1: it is that one

    CameraModel camera(const Eigen::VectorXd &x) const {
        return to_camera(x.segment(at, model.parameters()), model, width, height);
    }
    Pose from_color(const Eigen::VectorXd &x) const {
        return extrinsics_at < 0 ? Pose::identity() : exp(Twist(x.segment<6>(extrinsics_at)));
    }
    /// All of them that are to be found, and the pose of the board at `pose_at`.
    std::vector<int> free_parameters(int pose_at) const;
};

/// Where a camera sees the corners of a board at `pose`, less where they are, two numbers each.
void corner_residuals(const std::vector<Eigen::Vector2d> &places, const Corners &corners,
                      const CameraModel &camera, const Pose &pose, double noise_px,
                      Eigen::Ref<Eigen::VectorXd> residuals);
/// The same of the unknowns; `places` is Board::corners(). Both must outlive the block.
ResidualBlock corner_block(const std::vector<Eigen::Vector2d> &places, const Corners &corners,
                           const CameraUnknowns &camera, int pose_at, double noise_px);

/// A reading of a TOF camera.
struct DepthReading {
    double u = 0, v = 0;
    double m = 0; ///< along Z or along the ray
};

/// Unit: metres in the frame of the camera that gave it.
Eigen::Vector3d point_of(const DepthReading &reading, const CameraModel &camera,
                         bool range_along_ray);

/// Readings, times `scale`, less what the plane of a board at `pose` lets expect of their pixels.
/// In the direction that is measured: across the plane, noise would shrink with each change of the
/// camera that makes rays graze it, and the camera be found with that change.
void plane_residuals(std::span<const DepthReading> readings, const CameraModel &camera,
                     bool range_along_ray, const Pose &pose, double noise_m, double scale,
                     Eigen::Ref<Eigen::VectorXd> residuals);

/// The standard deviation of residuals about 0, without outliers: those more than five times as
/// large as the median of |r| lets expect.
double noise_of(std::vector<double> residuals);
/// The same of blocks at x, in units of what they expect.
double noise_of(const Eigen::VectorXd &x, const std::vector<ResidualBlock> &blocks);

} // namespace afterglow
