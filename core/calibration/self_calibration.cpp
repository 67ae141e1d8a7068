// SPDX-License-Identifier: Apache-2.0
#include "core/calibration/self_calibration.hpp"

#include <Eigen/Cholesky>
#include <Eigen/LU>

namespace afterglow {

SelfCalibration::SelfCalibration(const SelfCalibrationOptions &options)
    : sigma_(options.tilt, options.tilt, options.curvature, options.lag_s),
      pair_variance_(Eigen::Vector4d(options.pair_error, options.pair_error, options.pair_error,
                                     options.lag_pair_error)
                         .cwiseAbs2()) {}

void SelfCalibration::add(const CalibrationEvidence &evidence) {
    constexpr double most = 3.0; // sigmas
    const Eigen::Matrix4d H = sigma_.asDiagonal() * evidence.H * sigma_.asDiagonal();
    const Eigen::Vector4d g = sigma_.asDiagonal() * evidence.g;
    // However many readings a pair has, the systematic part of its covariance stays.
    const Eigen::Matrix4d damping =
        (Eigen::Matrix4d::Identity() + H * pair_variance_.asDiagonal()).inverse();
    const CalibrationEvidence sum{sum_.H + damping * H, sum_.g + damping * g};
    const Eigen::Vector4d p =
        (sum.H + Eigen::Matrix4d::Identity()).ldlt().solve(sum.g).cwiseMax(-most).cwiseMin(most);
    if (!p.allFinite() || !sum.H.allFinite() || !sum.g.allFinite())
        return;
    sum_ = sum;
    correction_.shape = sigma_.head<3>().cwiseProduct(p.head<3>()).cast<float>();
    correction_.lag_s = sigma_[3] * p[3];
}

} // namespace afterglow
