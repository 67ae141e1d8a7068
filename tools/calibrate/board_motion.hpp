// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "core/base/rigid_motion.hpp"

#include <Eigen/Core>

namespace afterglow {

/// A smooth motion of a board: translation, and rotation from a middle one, are uniform cubic
/// B-splines in time. Their control points are parameters of a least squares problem, six each.
class BoardMotionSpline {
public:
    /// From `begin_s` to `end_s`, beyond which time stands still; parameters from `at` on.
    BoardMotionSpline(double begin_s, double end_s, const Eigen::Matrix3d &middle, int at);

    int at() const { return at_; }
    int control_points() const { return count_; }
    /// The control points that have a say from one time to another, the first and the last.
    struct Controls {
        int first, last;
    };
    Controls controls(double from_s, double to_s) const;

    /// Writes what goes through a pose at the time of each control point, about.
    void start_at(int control, const Pose &pose, Eigen::VectorXd &x) const;
    double time_of(int control) const; ///< at which it weighs most

    Pose pose(const Eigen::VectorXd &x, double t_s) const;

private:
    double knot(double t_s) const;

    double begin_s_, end_s_;
    Eigen::Matrix3d middle_;
    int at_, count_;
};

} // namespace afterglow
