// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "core/base/camera.hpp"
#include "core/base/pyramid.hpp"
#include "core/base/rigid_motion.hpp"
#include "core/calibration_state.hpp"
#include "core/keyframe/depth_edges.hpp"
#include "core/keyframe/depth_surface.hpp"
#include "core/keyframe/edge_view.hpp"

#include <Eigen/Core>

#include <array>
#include <vector>

namespace afterglow {

/// Watches whether depth maps and images still fit each other: where a surface ends before one
/// further away, the image has an edge, too. The RigError that brings the edges of the last few
/// measurements onto those of their images is looked for, coarsely over some two degrees and then
/// by weighted least squares (docs/estimation.md). A camera at rest tells all but the lag.
///
/// Allocates when made; add() is real-time safe. One thread.
class CalibrationWatch {
public:
    /// `camera`: of the images before they were halved `levels` times.
    CalibrationWatch(const Intrinsics &camera, int levels);

    /// A measurement. `surface` as `surface_camera` sees it, whose points `pose` takes to the
    /// camera of `image`, both as calibrated; `rate`: motion (v, w) of the scene per second as that
    /// camera sees it, 0 where it is not known. A surface with few edges changes nothing.
    void add(const DepthSurface &surface, const Intrinsics &surface_camera, const Pose &pose,
             const Pyramid &image, const Twist &rate);

    /// Absolute: relative to the calibration that add() was given.
    const CalibrationState &state() const { return state_; }
    /// What takes points, brought by the calibration to the colour camera, to where they are, and
    /// what that camera's focal lengths are to be multiplied with. Identity and 1, but for the
    /// parts that are suspect.
    const Pose &correction() const { return correction_; }
    double focal_scale() const { return focal_scale_; }
    /// By how much image directions are wrong, as calibrated and after correction: radians, one
    /// sigma over the edges seen, 0 while rotation, translation and focal length are not suspect.
    float shift() const { return shift_; }
    float corrected_shift() const { return corrected_shift_; }

private:
    using Matrix9 = Eigen::Matrix<double, 9, 9>;
    struct Fit {
        RigError error = RigError::Zero();
        double score = -1e9;         ///< mean of the profiles, less what the prior says against it
        Matrix9 H = Matrix9::Zero(); ///< information, in sigmas of the prior
    };

    double look(const RigError &error);
    double against(const RigError &error) const;
    Fit refine(const RigError &start);
    EdgeEvidence gather(double kernel) const;
    RigError search(const EdgeView &view);
    void judge(const Fit &fit, bool better);
    Matrix9 sensitivity() const;

    int level_; ///< of the pyramid, that is looked at
    Intrinsics camera_;
    DepthEdges finder_;
    std::vector<EdgeView> views_;
    std::vector<EdgeProfiles> profiles_; ///< of each view
    std::size_t seen_ = 0;               ///< measurements so far
    RigError error_ = RigError::Zero();
    std::array<int, calibration_parts> against_{}; ///< verdicts in a row that differ from state_
    CalibrationState state_;
    Pose correction_;
    double focal_scale_ = 1;
    float shift_ = 0, corrected_shift_ = 0;
};

} // namespace afterglow
