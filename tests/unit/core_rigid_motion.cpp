// SPDX-License-Identifier: Apache-2.0
#include "core/base/rigid_motion.hpp"
#include "tests/catch.hpp"

#include <Eigen/LU>

#include <cmath>
#include <numbers>

using namespace afterglow;

namespace {

Twist motion(double vx, double vy, double vz, double wx, double wy, double wz) {
    Twist m;
    m << vx, vy, vz, wx, wy, wz;
    return m;
}

double difference(const Pose &a, const Pose &b) {
    return (a.R - b.R).norm() + (a.T - b.T).norm();
}

const Pose turned = exp(motion(0.3, -0.2, 1.1, 0.4, -1.1, 0.3));

} // namespace

TEST_CASE("the logarithm of a pose's exponential is the motion it was made of") {
    for (const Twist &m : {motion(0.1, -0.2, 0.3, 0.2, -0.1, 0.5), motion(1, 2, 3, 0, 0, 0),
                           motion(0, 0, 0, 1e-7, -2e-7, 1e-8), motion(0, 0, 0, 1e-13, 0, 0),
                           motion(0, 0, 0, 0, 0, 1e-3), motion(1, 0, 0, 0, 3.1, 0)})
        CHECK((log(exp(m)) - m).norm() < 1e-9);
}

TEST_CASE("a rotation by nearly half a turn survives logarithm and exponential") {
    for (const double off : {1e-3, 1e-6, 1e-9, 0.0, -1e-9, -1e-6}) {
        const Eigen::Vector3d axis = Eigen::Vector3d(1, -2, 0.5).normalized();
        const Pose pose{rotation(axis * (std::numbers::pi + off)), {1, 2, 3}};
        CHECK(difference(exp(log(pose)), pose) < 1e-7);
        CHECK(log(pose).tail<3>().norm() <= std::numbers::pi + 1e-9);
    }
}

TEST_CASE("a rotation matrix is orthonormal for tiny and for large rotation vectors") {
    for (const double angle : {0.0, 1e-14, 1e-12, 1e-9, 1e-3, 1.0, 3.14159, 6.0}) {
        const Eigen::Matrix3d R = rotation(Eigen::Vector3d(0.6, 0, -0.8) * angle);
        CHECK((R * R.transpose() - Eigen::Matrix3d::Identity()).norm() < 1e-12);
        CHECK(R.determinant() == Approx(1));
    }
}

TEST_CASE("the adjoint moves a small motion from before a pose to after it") {
    const Twist small = 1e-5 * motion(0.5, 1, -2, 1, -0.7, 0.2);
    const Twist after = adjoint(turned) * small;
    CHECK(difference(turned * exp(small), exp(after) * turned) < 1e-9);
    CHECK(difference(turned * exp(small), exp(small) * turned) > 1e-6);
}

TEST_CASE("the adjoint of a product of poses is the product of their adjoints") {
    const Pose other = exp(motion(-1, 0.5, 0.2, -0.3, 0.2, 0.9));
    CHECK((adjoint(turned * other) - adjoint(turned) * adjoint(other)).norm() < 1e-12);
    CHECK((adjoint(turned.inverse()) - adjoint(turned).inverse()).norm() < 1e-12);
}

TEST_CASE("a pose times its inverse is the identity, and products apply the right factor first") {
    CHECK(difference(turned * turned.inverse(), Pose::identity()) < 1e-12);
    const Pose other = exp(motion(-1, 0.5, 0.2, -0.3, 0.2, 0.9));
    const Eigen::Vector3d X{0.3, -0.4, 2};
    CHECK(((turned * other) * X - turned * (other * X)).norm() < 1e-12);
}

TEST_CASE("interpolation of a motion starts at the identity, ends at the motion and goes beyond") {
    CHECK(difference(part_of(turned, 0), Pose::identity()) < 1e-12);
    CHECK(difference(part_of(turned, 1), turned) < 1e-12);
    const Pose half = part_of(turned, 0.5);
    CHECK(half.angle() == Approx(turned.angle() / 2));
    CHECK((half.R * half.R - turned.R).norm() < 1e-12);
    CHECK(part_of(turned, 2).angle() == Approx(2 * turned.angle()));
    CHECK((part_of(turned, -1).R - turned.R.transpose()).norm() < 1e-12);
}
