// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "core/base/rig_calibration.hpp"

namespace afterglow {

/// The cameras that a pipeline works for: two that see, and one whose view is published.
struct RigGeometry {
    /// A pinhole camera with depth registered to it, which is published.
    RigGeometry(const Intrinsics &camera) // NOLINT(google-explicit-constructor)
        : rig{.color = {.pinhole = camera}, .tof = {.pinhole = camera}}, published(rig.color),
          registered(true) {}
    /// Two cameras of a rig, and the published one.
    RigGeometry(const RigCalibration &calibration, const CameraModel &published_camera,
                const Pose &published_from_color_camera)
        : rig(calibration), published(published_camera),
          published_from_color(published_from_color_camera) {}

    RigCalibration rig;
    CameraModel published;
    Pose published_from_color; ///< takes points of the colour camera's frame to the published one's
    /// Depth maps are registered to the colour camera: they show what it would see, in its size.
    bool registered = false;

    /// Each camera is as large as the other rig's.
    bool same_sizes(const RigGeometry &other) const {
        const auto same = [](const CameraModel &a, const CameraModel &b) {
            return a.pinhole.width == b.pinhole.width && a.pinhole.height == b.pinhole.height;
        };
        return same(rig.color, other.rig.color) && same(rig.tof, other.rig.tof) &&
               same(published, other.published);
    }
    bool operator==(const RigGeometry &other) const {
        return rig == other.rig && published == other.published &&
               published_from_color == other.published_from_color && registered == other.registered;
    }

    /// The one pinhole camera of a registered rig.
    const Intrinsics &camera() const { return published.pinhole; }
    /// What is published is seen along the rays of measured maps, pixel by pixel.
    bool publishes_readings() const { return publishes_tof() && published == rig.tof; }
    /// What is published is seen along the rays of images, pixel by pixel.
    bool publishes_color() const {
        return published == rig.color && published_from_color.R.isIdentity() &&
               published_from_color.T.isZero();
    }
    /// The published camera is where the TOF camera is, and looks the same way.
    bool publishes_tof() const { return published_from_color == rig.tof_from_color; }
};

} // namespace afterglow
