// SPDX-License-Identifier: Apache-2.0
#include "tools/calibrate/board_motion.hpp"

#include <algorithm>
#include <cmath>

namespace afterglow {
namespace {

/// A hand does not turn faster than that it follows.
constexpr double spacing_s = 0.1;

} // namespace

BoardMotionSpline::BoardMotionSpline(double begin_s, double end_s, const Eigen::Matrix3d &middle,
                                     int at)
    : begin_s_(begin_s), end_s_(end_s), middle_(middle), at_(at),
      count_(static_cast<int>(std::ceil((end_s - begin_s) / spacing_s)) + 4) {}

/// In knots from the begin, within what there is.
double BoardMotionSpline::knot(double t_s) const {
    return (std::clamp(t_s, begin_s_, end_s_) - begin_s_) / spacing_s;
}

BoardMotionSpline::Controls BoardMotionSpline::controls(double from_s, double to_s) const {
    return {static_cast<int>(knot(from_s)), static_cast<int>(knot(to_s)) + 3};
}

double BoardMotionSpline::time_of(int control) const {
    return begin_s_ + (control - 1) * spacing_s;
}

void BoardMotionSpline::start_at(int control, const Pose &pose, Eigen::VectorXd &x) const {
    x.segment<6>(at_ + 6 * control) = log(Pose{pose.R * middle_.transpose(), pose.T});
}

Pose BoardMotionSpline::pose(const Eigen::VectorXd &x, double t_s) const {
    const double k = knot(t_s);
    const int first = static_cast<int>(k);
    const double s = k - first, r = 1 - s;
    const double weights[] = {r * r * r / 6, (3 * s * s * s - 6 * s * s + 4) / 6,
                              (3 * r * r * r - 6 * r * r + 4) / 6, s * s * s / 6};
    Twist motion = Twist::Zero();
    for (int i = 0; i < 4; ++i)
        motion += weights[i] * x.segment<6>(at_ + 6 * (first + i));
    return {rotation(motion.tail<3>()) * middle_, motion.head<3>()};
}

} // namespace afterglow
