// SPDX-License-Identifier: Apache-2.0
#include "tools/ctl/calibration/rig_figures.hpp"

#include "core/base/degrees.hpp"

#include <Eigen/Geometry>
#include <fmt/format.h>

#include <algorithm>
#include <cmath>

namespace afterglow {
namespace {

constexpr double widest_degrees = 170;
constexpr double most_off_center = 0.1;  // of the width
constexpr double most_unequal = 0.05;    // of the focal length
constexpr double longest_baseline = 0.3; // metres
constexpr double most_outside = 0.25;
/// At depth 1: a ray that is seen at a pixel is not seen there when the lens turns back before it.
constexpr double same_ray = 1e-3;

/// Between two rays.
double angle(const Eigen::Vector2d &a, const Eigen::Vector2d &b) {
    const Eigen::Vector3d from(a.x(), a.y(), 1), to(b.x(), b.y(), 1);
    return std::atan2(from.cross(to).norm(), from.dot(to)) * degrees_per_radian;
}

bool sees(const CameraModel &camera, const Eigen::Vector3d &X) {
    if (X.z() <= 0)
        return false;
    const Eigen::Vector2d pixel = camera.project(X);
    const auto &[fx, fy, cx, cy, width, height] = camera.pinhole;
    if (!(pixel.x() >= -0.5 && pixel.x() < width - 0.5 && pixel.y() >= -0.5 &&
          pixel.y() < height - 0.5))
        return false;
    const auto ray = camera.ray(pixel.x(), pixel.y());
    return ray && (*ray - X.head<2>() / X.z()).norm() < same_ray;
}

/// The first pixel on the border without a ray. The lens turns back there first.
std::optional<Eigen::Vector2i> blind_pixel(const CameraModel &camera) {
    const int right = camera.pinhole.width - 1, bottom = camera.pinhole.height - 1;
    std::vector<Eigen::Vector2i> border;
    for (int u = 0; u <= right; ++u)
        border.insert(border.end(), {{u, 0}, {u, bottom}});
    for (int v = 0; v <= bottom; ++v)
        border.insert(border.end(), {{0, v}, {right, v}});
    const auto blind = std::find_if(border.begin(), border.end(), [&](const Eigen::Vector2i &p) {
        return !camera.ray(p.x(), p.y());
    });
    return blind == border.end() ? std::nullopt : std::optional(*blind);
}

void suspect(const char *which, const CameraModel &camera, std::vector<std::string> &found) {
    const auto &[fx, fy, cx, cy, width, height] = camera.pinhole;
    const auto say = [&](std::string sentence) {
        found.push_back(fmt::format("{}: {}", which, sentence));
    };
    const CameraFigures figures = figures_of(camera);
    const double widest = std::max(figures.horizontal_degrees, figures.vertical_degrees);
    if (widest > widest_degrees)
        say(fmt::format("its field of view is {:.1f} degrees (usual: at most {:.0f})", widest,
                        widest_degrees));
    const double off =
        std::max(std::abs(cx - (width - 1) / 2.0), std::abs(cy - (height - 1) / 2.0));
    if (off > most_off_center * width)
        say(fmt::format(
            "its principal point is {:.0f} pixels off the middle, {:.0f} % of the width "
            "(usual: at most {:.0f} %); was the picture cropped or resized?",
            off, 100 * off / width, 100 * most_off_center));
    if (std::abs(fx / fy - 1) > most_unequal)
        say(fmt::format("its pixels are not square: fx is {:.3f} times fy (usual: within {:.0f} %)",
                        fx / fy, 100 * most_unequal));
    if (const auto blind = blind_pixel(camera))
        say(fmt::format("its lens turns back inside the picture: there is no ray at pixel ({}, {})",
                        blind->x(), blind->y()));
}

} // namespace

CameraFigures figures_of(const CameraModel &camera) {
    const double right = camera.pinhole.width - 1, bottom = camera.pinhole.height - 1;
    const auto ray = [&](double u, double v) {
        return camera.ray(u, v).value_or(Eigen::Vector2d::Zero());
    };
    CameraFigures figures{};
    figures.horizontal_degrees = angle(ray(0, bottom / 2), ray(right, bottom / 2));
    figures.vertical_degrees = angle(ray(right / 2, 0), ray(right / 2, bottom));
    for (const double u : {0.0, right})
        for (const double v : {0.0, bottom}) {
            const Eigen::Vector2d r = ray(u, v);
            const Eigen::Vector2d straight = camera.pinhole.project({r.x(), r.y(), 1});
            figures.lens_px = std::max(figures.lens_px, (straight - Eigen::Vector2d(u, v)).norm());
        }
    return figures;
}

double share_outside(const CameraModel &color, const CameraModel &tof, const Pose &tof_from_color) {
    const Pose color_from_tof = tof_from_color.inverse();
    constexpr int rows = 32;
    int outside = 0;
    for (int j = 0; j < rows; ++j)
        for (int i = 0; i < rows; ++i) {
            const auto ray = tof.ray((i + 0.5) * tof.pinhole.width / rows - 0.5,
                                     (j + 0.5) * tof.pinhole.height / rows - 0.5);
            outside +=
                !ray || !sees(color, color_from_tof * Eigen::Vector3d(ray->x(), ray->y(), 1));
        }
    return static_cast<double>(outside) / (rows * rows);
}

std::vector<std::string> suspicions(const PartialRig &rig) {
    std::vector<std::string> found;
    if (rig.color)
        suspect("colour camera", rig.color->model, found);
    if (rig.tof)
        suspect("TOF camera", rig.tof->model, found);
    if (!rig.tof_from_color)
        return found;
    if (const double baseline = rig.tof_from_color->T.norm(); baseline > longest_baseline)
        found.push_back(fmt::format("the cameras are {:.3g} m apart (usual: at most {} m); is "
                                    "--translation-unit right?",
                                    baseline, longest_baseline));
    const double outside = share_outside(rig.color->model, rig.tof->model, *rig.tof_from_color);
    if (outside > most_outside)
        found.push_back(
            fmt::format("at 1 m, {:.0f} % of the TOF camera's picture is outside that of "
                        "the colour camera (usual: at most {:.0f} %); is --invert "
                        "needed, or are the cameras exchanged?",
                        100 * outside, 100 * most_outside));
    return found;
}

} // namespace afterglow
