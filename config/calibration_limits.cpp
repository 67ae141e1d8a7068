// SPDX-License-Identifier: Apache-2.0
#include "config/calibration_limits.hpp"

#include "core/rig/working_views.hpp"

#include <Eigen/LU>
#include <Eigen/SVD>
#include <fmt/format.h>

#include <algorithm>

namespace afterglow {
namespace {

constexpr double orthonormal = 1e-3;
constexpr double rounding = 1e-14;

std::optional<CalibrationProblem> out_of(double minimum, double maximum, std::string_view key,
                                         double value, const char *unit) {
    if (value >= minimum && value <= maximum)
        return std::nullopt;
    return CalibrationProblem{key, fmt::format("{:g} is not allowed (a number from {:g} to {:g}{})",
                                               value, minimum, maximum, unit)};
}

/// The lens shows a ray from the principal point this far towards pixel `to`, in pixels.
double radius_with_ray(const CameraModel &camera, const Eigen::Vector2d &to) {
    constexpr int steps = 256;
    const Eigen::Vector2d center(camera.pinhole.cx, camera.pinhole.cy);
    double share = 0;
    for (int i = 1; i <= steps; ++i) {
        const Eigen::Vector2d at = center + (to - center) * i / steps;
        if (!camera.ray(at.x(), at.y()))
            break;
        share = static_cast<double>(i) / steps;
    }
    return share * (to - center).norm();
}

std::optional<CalibrationProblem> problem_of_lens(const CameraModel &camera) {
    if (!std::all_of(camera.distortion.begin(), camera.distortion.end(),
                     [](double k) { return std::isfinite(k); }))
        return CalibrationProblem{"distortion", "is not finite"};
    const Intrinsics &pinhole = camera.pinhole;
    constexpr int last = 16;
    for (int j = 0; j <= last; ++j)
        for (int i = 0; i <= last; ++i) {
            const Eigen::Vector2d pixel((pinhole.width - 1) * i / double{last},
                                        (pinhole.height - 1) * j / double{last});
            if (camera.ray(pixel.x(), pixel.y()))
                continue;
            const Eigen::Vector2d center(pinhole.cx, pinhole.cy);
            return CalibrationProblem{
                "distortion",
                fmt::format("the lens shows no ray at pixel ({:.0f}, {:.0f}), {:.0f} pixels from "
                            "the principal point: in this direction it does up to {:.0f} (all "
                            "pixels of the picture must have one)",
                            pixel.x(), pixel.y(), (pixel - center).norm(),
                            radius_with_ray(camera, pixel))};
        }
    return std::nullopt;
}

} // namespace

std::optional<CalibrationProblem> problem_of(const CameraModel &camera) {
    const auto &[fx, fy, cx, cy, width, height] = camera.pinhole;
    for (const auto &problem :
         {out_of(16, 4096, "width", width, " pixels"),
          out_of(16, 4096, "height", height, " pixels"), out_of(1, 100000, "fx", fx, " pixels"),
          out_of(1, 100000, "fy", fy, " pixels"), out_of(-width, 2 * width, "cx", cx, " pixels"),
          out_of(-height, 2 * height, "cy", cy, " pixels")})
        if (problem)
            return problem;
    return problem_of_lens(camera);
}

std::optional<CalibrationProblem> problem_of(const RigCalibration &rig) {
    const double distance = rig.tof_from_color.T.norm();
    if (!(distance <= 1))
        return CalibrationProblem{
            "translation_m",
            fmt::format("{:g} m between the cameras is not allowed (at most 1 m)", distance)};
    if (auto problem = out_of(-1000, 1000, "delay_ms", rig.tof_delay_s * 1000, " ms"))
        return problem;
    if (auto problem = out_of(0, 1000, "readout_ms", rig.readout_s * 1000, " ms"))
        return problem;
    if (!problem_of(rig.color) && !problem_of(rig.tof) &&
        !views_meet({rig, rig.color, Pose::identity()}))
        return CalibrationProblem{"rotation", "turns the cameras so that the colour camera sees "
                                              "nothing of what the TOF camera sees"};
    return std::nullopt;
}

std::optional<Eigen::Matrix3d> exact_rotation(const Eigen::Matrix3d &R) {
    const double off = (R * R.transpose() - Eigen::Matrix3d::Identity()).cwiseAbs().maxCoeff();
    if (!(off <= orthonormal) || R.determinant() < 0)
        return std::nullopt;
    if (off <= rounding)
        return R;
    const Eigen::JacobiSVD<Eigen::Matrix3d> svd(R, Eigen::ComputeFullU | Eigen::ComputeFullV);
    return svd.matrixU() * svd.matrixV().transpose();
}

} // namespace afterglow
