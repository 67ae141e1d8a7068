// SPDX-License-Identifier: Apache-2.0
#include "core/keyframe/map_registration.hpp"

#include <Eigen/Cholesky>

namespace afterglow {

DepthFit MapRegistration::add(const Keyframe &reference, const DepthSurface &fresh,
                              const Pose &expected, const Alignment &alignment, const Twist &rate) {
    using Matrix6f = Eigen::Matrix<float, 6, 6>;
    Matrix6f information = Matrix6f::Zero();
    if (alignment.good) {
        const Matrix6f after = adjoint(surface_from_tracking_ * alignment.pose).cast<float>();
        Matrix6f covariance = after * alignment.covariance * after.transpose();
        covariance.diagonal().array() += 1e-8f;
        information = covariance.ldlt().solve(Matrix6f::Identity());
    }
    const Pose start = expected * reference.depth_from_world.inverse();
    const DepthFit fit = refine_by_depth(reference.surface, fresh, camera_, start, information);
    if (fit.good && alignment.good) {
        const Eigen::Matrix3d &R = surface_from_tracking_.R;
        const Eigen::Vector3d rate_change =
            R * rate.tail<3>() - fit.pose.R * (R * reference.rate.tail<3>());
        self_calibration_.add(calibration_evidence(reference.surface, fresh, camera_, fit, start,
                                                   information, rate_change, correction().lag_s));
    }
    return fit;
}

} // namespace afterglow
