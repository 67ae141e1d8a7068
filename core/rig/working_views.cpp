// SPDX-License-Identifier: Apache-2.0
#include "core/rig/working_views.hpp"

#include "core/rig/pixel_places.hpp"

#include <Eigen/Geometry>

#include <algorithm>
#include <cassert>
#include <cmath>

namespace afterglow {
namespace {

/// Depths between which the TOF camera's view is looked for in another camera's, metres.
constexpr double nearest_m = 0.3, farthest_m = 10;
/// Share of a view's sides that is added for what has just left the TOF camera's view.
constexpr double margin = 0.1;
constexpr double working_width = 640;
/// Beyond it a pinhole picture is mostly border: 70 degrees off the axis.
constexpr double widest_ray = 2.75;
constexpr int grid = 16;
/// Sizes are multiples of it, so that no level of a pyramid has a remainder.
constexpr int size_step = 16;

/// A field of view: rays, at depth 1.
using Field = Eigen::AlignedBox2d;

/// Calls visit(u, v) for places all over a camera's picture, its corners included.
template <class Visit>
void for_each_place(const Intrinsics &camera, const Visit &visit) {
    for (int y = 0; y <= grid; ++y)
        for (int x = 0; x <= grid; ++x)
            visit((camera.width - 1) * x / static_cast<double>(grid),
                  (camera.height - 1) * y / static_cast<double>(grid));
}

/// The rays that a camera sees, as far as a pinhole picture can show them.
Field field_of(const CameraModel &camera) {
    Field field;
    for_each_place(camera.pinhole, [&](double u, double v) {
        if (const auto ray = camera.ray(u, v))
            field.extend(ray->cwiseMax(-widest_ray).cwiseMin(widest_ray));
    });
    return field;
}

/// The rays along which `camera` may see what the TOF camera sees, widened on each side by
/// `more_share` of the field's size; empty if there are none.
Field field_of_tof(const CameraModel &tof, const CameraModel &camera, const Pose &camera_from_tof,
                   double more_share = margin) {
    Field field;
    for_each_place(tof.pinhole, [&](double u, double v) {
        const auto ray = tof.ray(u, v);
        if (!ray)
            return;
        for (const double z : {nearest_m, farthest_m}) {
            const Eigen::Vector3d X =
                camera_from_tof * Eigen::Vector3d(z * ray->x(), z * ray->y(), z);
            if (X.z() > 0.1 * z)
                field.extend((X.head<2>() / X.z()).cwiseMax(-widest_ray).cwiseMin(widest_ray));
        }
    });
    if (field.isEmpty())
        return field;
    const Eigen::Vector2d more = more_share * field.sizes();
    field.min() -= more;
    field.max() += more;
    return field.intersection(field_of(camera));
}

/// The pinhole camera that sees `field` with focal length f, or a little more.
Intrinsics pinhole_of(const Field &field, double f) {
    const auto pixels = [&](double side) {
        return std::max(1, static_cast<int>(std::ceil(side * f / size_step))) * size_step;
    };
    Intrinsics camera{f, f, 0, 0, pixels(field.sizes().x()), pixels(field.sizes().y())};
    camera.cx = (camera.width - 1) / 2.0 - f * field.center().x();
    camera.cy = (camera.height - 1) / 2.0 - f * field.center().y();
    return camera;
}

/// Pixels to the unit of rays at the middle of the picture.
double density(const CameraModel &camera) {
    return std::sqrt(camera.pinhole.fx * camera.pinhole.fy);
}

} // namespace

bool views_meet(const RigGeometry &geometry) {
    const RigCalibration &rig = geometry.rig;
    const Pose color_from_tof = rig.tof_from_color.inverse();
    const auto meets = [&](const CameraModel &camera, const Pose &camera_from_color) {
        return !field_of_tof(rig.tof, camera, camera_from_color * color_from_tof, 0).isEmpty();
    };
    return meets(rig.color, Pose::identity()) &&
           meets(geometry.published, geometry.published_from_color);
}

Views working_views(const RigGeometry &geometry) {
    const RigCalibration &rig = geometry.rig;
    assert(views_meet(geometry));
    Views views;
    views.calibrated = true;
    views.surface_from_tracking = rig.tof_from_color;
    views.published_from_tracking = geometry.published_from_color;

    const Pose color_from_tof = rig.tof_from_color.inverse();
    const Field seen_by_color = field_of_tof(rig.tof, rig.color, color_from_tof);
    views.tracking = pinhole_of(
        seen_by_color, std::min(density(rig.color), working_width / seen_by_color.sizes().x()));
    double f = views.tracking.fx;
    if (geometry.publishes_color()) {
        views.published = views.tracking;
    } else {
        const Field published = field_of_tof(rig.tof, geometry.published,
                                             geometry.published_from_color * color_from_tof);
        f = std::max(working_width / published.sizes().x(), density(rig.tof));
        f = std::min({f, 2 * density(rig.tof), density(geometry.published)});
        if (geometry.publishes_tof())
            f = std::max(f, density(rig.tof));
        views.published = pinhole_of(published, f);
    }
    views.surface = geometry.publishes_tof() ? views.published : pinhole_of(field_of(rig.tof), f);
    // The rows of the tracking camera are a part of the colour camera's.
    const double rows = views.tracking.height / views.tracking.fy;
    const double all_rows = rig.color.pinhole.height / rig.color.pinhole.fy;
    views.readout_s = rig.readout_s * std::min(1.0, rows / all_rows);
    return views;
}

} // namespace afterglow
