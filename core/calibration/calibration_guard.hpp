// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "core/alignment/camera_motion.hpp"
#include "core/base/pyramid.hpp"
#include "core/base/views.hpp"
#include "core/base/worker_pool.hpp"
#include "core/calibration/calibration_watch.hpp"
#include "core/surface/depth_surface.hpp"
#include "core/warp/surface_registration.hpp"

namespace afterglow {

/// Keeps a calibration true: watches it, and moves measured surfaces from where the TOF camera is
/// found to be to where it is told to be, so that nothing else needs to know. While a lag is
/// suspect nothing is moved. Depth that is published along the TOF camera's own rays stays where it
/// was measured.
///
/// Allocates when made; check() is real-time safe. One thread.
class CalibrationGuard {
public:
    /// `coarsest_level`: of the images' pyramids.
    CalibrationGuard(const Views &views, int coarsest_level, const WarpOptions &options,
                     WorkerPool &pool);

    /// A measured surface, exposed `lag_s` seconds after `image` as stamps say, is looked at and
    /// corrected. `motion`: of the tracking camera. True when the correction has changed.
    bool check(DepthSurface &surface, const CameraMotion &motion, double lag_s,
               const Pyramid &image);
    /// As the watch has it, and what of it is corrected.
    const CalibrationState &state() const { return state_; }
    /// CalibrationWatch::shift() of what is not corrected.
    float shift() const { return watch_.shift(applied_); }

private:
    Views views_;
    WorkerPool &pool_;
    bool corrects_;
    CalibrationWatch watch_;
    RigError applied_ = RigError::Zero(); ///< what surfaces are corrected by
    CalibrationState state_;
    SurfaceRendering rendering_;
};

} // namespace afterglow
