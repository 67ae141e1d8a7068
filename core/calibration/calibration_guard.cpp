// SPDX-License-Identifier: Apache-2.0
#include "core/calibration/calibration_guard.hpp"

namespace afterglow {

CalibrationGuard::CalibrationGuard(const Views &views, int coarsest_level,
                                   const WarpOptions &options, WorkerPool &pool)
    : views_(views), pool_(pool),
      corrects_(views.publishes_tracking() || !views.publishes_surface()),
      watch_(views.tracking, coarsest_level),
      rendering_(views.surface, views.surface, options, pool) {}

bool CalibrationGuard::check(DepthSurface &surface, const CameraMotion &motion, double lag_s,
                             const Pyramid &image) {
    const Pose tracking_from_surface = views_.surface_from_tracking.inverse();
    watch_.add(surface, views_.surface, motion.moved_in(lag_s).inverse() * tracking_from_surface,
               image, motion.rate());
    state_ = watch_.state();
    if (!corrects_)
        return false;
    // What a lag moves may look turned or shifted, too.
    const bool correctable = !state_[CalibrationPart::lag].suspect;
    const bool changed = correctable ? watch_.differs(applied_) : !applied_.isZero(0);
    if (changed)
        applied_ = correctable ? watch_.suspected() : RigError::Zero();
    for (const CalibrationPart part :
         {CalibrationPart::rotation, CalibrationPart::translation, CalibrationPart::focal_length})
        state_[part].corrected = amount(applied_, part);
    if (!applied_.isZero(0)) {
        const Pose moved =
            views_.surface_from_tracking * correction(applied_) * tracking_from_surface;
        surface.rebuild(rendering_.run(surface, moved), pool_);
    }
    return changed;
}

} // namespace afterglow
