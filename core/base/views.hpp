// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "core/base/camera.hpp"
#include "core/base/rigid_motion.hpp"

namespace afterglow {

inline bool is_identity(const Pose &pose) {
    return pose.R.isIdentity(1e-9) && pose.T.isZero(1e-9);
}

/// The pinhole cameras that preset "default" works in. All move as one body.
struct Views {
    Views() = default;
    /// One camera for all: depth is registered to the images.
    Views(const Intrinsics &camera) // NOLINT(google-explicit-constructor)
        : tracking(camera), surface(camera), published(camera) {}

    Intrinsics tracking;  ///< images are aligned here
    Intrinsics surface;   ///< measured depth maps come in this one
    Intrinsics published; ///< composed depth maps leave in this one
    Pose surface_from_tracking;
    Pose published_from_tracking;
    /// Time from reading the first row of the tracking camera's picture to the last, seconds, for
    /// depth that is measured all at once; 0: not known, or depth is read the same way.
    double readout_s = 0;
    /// Where the cameras are was told by a calibration, and not by a device that registers depth.
    bool calibrated = false;

    Pose published_from_surface() const {
        return published_from_tracking * surface_from_tracking.inverse();
    }
    /// Composed maps show what images show, pixel by pixel.
    bool publishes_tracking() const {
        return published == tracking && is_identity(published_from_tracking);
    }
    /// Composed maps are seen along the rays of measured maps.
    bool publishes_surface() const { return is_identity(published_from_surface()); }
    /// Measured maps are published reading by reading.
    bool publishes_readings() const { return surface == published && publishes_surface(); }
};

} // namespace afterglow
