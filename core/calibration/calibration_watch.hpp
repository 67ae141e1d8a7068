// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "core/base/camera.hpp"
#include "core/base/pyramid.hpp"
#include "core/base/rigid_motion.hpp"
#include "core/calibration/depth_edges.hpp"
#include "core/calibration/edge_view.hpp"
#include "core/calibration_state.hpp"
#include "core/surface/depth_surface.hpp"

#include <Eigen/Core>

#include <array>
#include <span>
#include <vector>

namespace afterglow {

/// What takes points that the calibration brought to the colour camera to where an error says they
/// are; a focal length is corrected by widening the view, so the matrix is not a rotation.
Pose correction(const RigError &error);
/// A part of an error, as CalibrationFinding has it.
float amount(const RigError &error, CalibrationPart part);

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
    /// The error as far as it is suspect; rotation, translation and focal length of it can be
    /// corrected.
    const RigError &suspected() const { return suspected_; }
    /// `corrected` is not what suspected() is, by more than its uncertainty; the lag does not
    /// count.
    bool differs(const RigError &corrected) const;
    /// By how much image directions are wrong, radians, one sigma, where `corrected` of the error
    /// is made good: in the newest measurement, or over the remembered ones if that is more. 0
    /// while nothing is suspect.
    float shift(const RigError &corrected = RigError::Zero()) const;

private:
    using Matrix9 = Eigen::Matrix<double, 9, 9>;
    struct Fit {
        RigError error;
        EdgeEvidence evidence; ///< there
        double score = 0;      ///< mean over edges, less what is known against the error
    };

    void learn(std::span<const DepthEdge> edges, GreyView image, const Twist &rate);
    void gather(const RigError &error, std::size_t kernel, EdgeEvidence &sum) const;
    Fit refine(const RigError &start, std::size_t kernel);
    RigError search(const EdgeView &view) const;
    void judge(const Fit &fit);
    Matrix9 sensitivity() const;
    Matrix9 newest_sensitivity() const;
    double pixels(const RigError &error) const;

    int level_; ///< of the pyramid, that is looked at
    Intrinsics camera_;
    DepthEdges finder_;
    std::vector<EdgeView> views_;
    std::size_t seen_ = 0; ///< measurements so far
    RigError error_ = RigError::Zero();
    double dispersion_;    ///< variance of what edges say, times how many share an error
    bool credible_ = true; ///< error_ is near the calibration, or fits much better than that
    std::array<int, calibration_parts> against_{}; ///< verdicts in a row that differ from state_
    CalibrationState state_;
    RigError suspected_ = RigError::Zero();
    Matrix9 covariance_ = Matrix9::Zero(); ///< of the error, the likeliest parts being wrong
};

} // namespace afterglow
