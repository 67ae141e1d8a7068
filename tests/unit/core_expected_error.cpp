// SPDX-License-Identifier: Apache-2.0
#include "core/error/expected_error.hpp"
#include "core/keyframe/keyframe.hpp"
#include "tests/catch.hpp"

#include <cmath>
#include <random>

using namespace afterglow;

namespace {

const Intrinsics camera{260, 260, 159.5, 119.5, 320, 240};

/// Depth in metres at pixel (u, v) of the plane n.X = 1.
double plane_depth(const Eigen::Vector3d &n, double u, double v) {
    return 1 / n.dot(camera.back_project(u, v, 1));
}

/// The plane n.X = 1, seen in some rows.
DepthSurface plane(const Eigen::Vector3d &n, int first_row = 0, int end_row = camera.height) {
    DepthMap map(camera.width, camera.height);
    for (int v = first_row; v < end_row; ++v)
        for (int u = 0; u < camera.width; ++u)
            map(u, v) = static_cast<std::uint16_t>(std::lround(1000 * plane_depth(n, u, v)));
    WorkerPool pool(1);
    DepthSurface surface(camera, SurfaceOptions{});
    surface.build(map, pool);
    return surface;
}

/// Root mean square of dz/z over the picture of a plane that moves by samples of a motion's
/// deviations, each on its own.
double sampled(const Eigen::Vector3d &n, const Eigen::Matrix<double, 6, 1> &deviations) {
    std::mt19937 random(1);
    std::normal_distribution<double> normal;
    double sum = 0;
    int count = 0;
    for (int i = 0; i < 300; ++i) {
        Eigen::Matrix<double, 6, 1> motion;
        for (int k = 0; k < 6; ++k)
            motion[k] = deviations[k] * normal(random);
        const Pose pose = exp(motion);
        // n.X = 1 of the moved plane: X = R^T (Y - T).
        const Eigen::Vector3d moved = pose.R * n / (1 + (pose.R * n).dot(pose.T));
        for (int v = 16; v < camera.height; v += 32)
            for (int u = 16; u < camera.width; u += 32) {
                const double change = plane_depth(moved, u, v) / plane_depth(n, u, v) - 1;
                sum += change * change;
                ++count;
            }
    }
    return std::sqrt(sum / count);
}

} // namespace

TEST_CASE("depth error propagated from the pose covariance agrees with Monte Carlo samples",
          "[core]") {
    const Eigen::Vector3d n = GENERATE(Eigen::Vector3d{0, 0, 0.5}, Eigen::Vector3d{0.25, 0.1, 0.4});
    Eigen::Matrix<double, 6, 1> deviations = Eigen::Matrix<double, 6, 1>::Zero();
    SECTION("translation along the optical axis") {
        deviations[2] = 0.01;
    }
    SECTION("translation along the image") {
        deviations[0] = 0.01;
    }
    SECTION("rotation") {
        deviations[4] = 0.005;
    }
    SECTION("translation and rotation") {
        deviations << 0.004, 0.006, 0.003, 0.002, 0.004, 0.003;
    }
    const Eigen::Matrix<double, 6, 6> C = deviations.array().square().matrix().asDiagonal();
    const MapError error =
        map_error(plane(n), camera, Pose::identity(), C.cast<float>(), ErrorOptions{});
    CHECK(error.pose_relative == Approx(sampled(n, deviations)).epsilon(0.1).margin(2e-4));
}

TEST_CASE("a pose that is exactly known adds nothing to the expected error", "[core]") {
    const Pose moved{Eigen::Matrix3d::Identity(), {0.1, 0, 0}};
    const MapError error = map_error(plane({0, 0, 0.5}), camera, moved,
                                     Eigen::Matrix<float, 6, 6>::Zero(), ErrorOptions{});
    CHECK(error.pose_relative == 0.0f);
    CHECK(error.shift_px == 0.0f);
    const MapError fresh = fresh_map_error(plane({0, 0, 0.5}), camera, ErrorOptions{});
    CHECK(error.edge == fresh.edge);
    CHECK(fresh.edge == fresh.fresh_edge);
    CHECK(error.slope == fresh.slope);
}

TEST_CASE("the expected error of a pixel falls with edge distance and grows with noise", "[core]") {
    DepthMap map(camera.width, camera.height, std::uint16_t{2000});
    for (int v = 60; v < 180; ++v)
        for (int u = 80; u < 240; ++u)
            map(u, v) = 1000;
    WorkerPool pool(1);
    DepthSurface surface(camera, SurfaceOptions{});
    surface.build(map, pool);
    const auto known = Eigen::Matrix<float, 6, 6>::Zero();
    const MapError error = map_error(surface, camera, Pose::identity(), known, ErrorOptions{});
    const auto error_at = [&](float z, int distance) {
        return pixel_error(error, SensorNoise{}, 0.7f, z, distance).scaled({});
    };
    for (int distance = 1; distance < far_from_edge; ++distance)
        CHECK(error_at(1.0f, distance) > error_at(1.0f, distance + 1));
    CHECK(error_at(4.0f, 7) > error_at(1.0f, 7));
}

TEST_CASE("what measurements teach scales the error of a fresh map and what carrying it adds",
          "[core]") {
    const DepthSurface surface = plane({0, 0, 0.5});
    const SensorNoise noise;
    const auto error_of = [&](const Eigen::Matrix<float, 6, 6> &covariance, const Pose &pose,
                              const ErrorScales &scales) {
        const MapError map = map_error(surface, camera, pose, covariance, ErrorOptions{});
        return pixel_error(map, noise, 0.7f, 2.0f, far_from_edge).scaled(scales);
    };
    const Eigen::Matrix<float, 6, 6> known = Eigen::Matrix<float, 6, 6>::Zero();
    const Eigen::Matrix<float, 6, 6> vague = 1e-4f * Eigen::Matrix<float, 6, 6>::Identity();
    const Pose moved{Eigen::Matrix3d::Identity(), {0.1, 0, 0}};
    const float fresh = error_of(known, Pose::identity(), {});
    const float carried = std::sqrt(std::pow(error_of(vague, moved, {}), 2.0f) - fresh * fresh);
    REQUIRE(carried > 0.001f);
    // A map that has not been carried has the one part alone.
    CHECK(error_of(known, Pose::identity(), {.fresh = 2, .carried = 5}) == Approx(2 * fresh));
    CHECK(error_of(vague, moved, {.fresh = 2, .carried = 3}) ==
          Approx(std::hypot(2 * fresh, 3 * carried)));
}

TEST_CASE("a strip of readings is expected to be as wrong wherever in the picture it is",
          "[core]") {
    const Eigen::Vector3d n{0.05, 0.1, 0.4};
    const Eigen::Matrix<float, 6, 6> covariance = 1e-4f * Eigen::Matrix<float, 6, 6>::Identity();
    const auto error_of = [&](const DepthSurface &strip) {
        return map_error(strip, Views(camera), {}, covariance, ErrorOptions{});
    };
    const int rows = GENERATE(30, 6, 1);
    const int on_grid = GENERATE(1, 0);
    const DepthSurface strip = on_grid != 0 ? plane(n, 112, 112 + rows) : plane(n, 113, 113 + rows);
    const MapError whole = error_of(plane(n, 100, 140)), error = error_of(strip);
    CHECK(error.pose_relative == Approx(whole.pose_relative).epsilon(0.2));
    CHECK(error.shift_px == Approx(whole.shift_px).epsilon(0.2));
    CHECK(visible_share(strip, camera, {}, camera) >
          0.99f); // pixels of column 0 may be just outside
    CHECK(mean_displacement(strip, camera, {Eigen::Matrix3d::Identity(), {0.01, 0, 0}}) > 0);
    if (rows > 1)
        CHECK(error.slope == Approx(whole.slope).epsilon(0.5));
}

TEST_CASE("a map of which no pixel is in view is expected to be wrong by its whole depth",
          "[core]") {
    const MapError error =
        map_error(plane({0, 0, 0.5}), camera, Pose{Eigen::Matrix3d::Identity(), {50, 0, 0}},
                  Eigen::Matrix<float, 6, 6>::Identity(), ErrorOptions{});
    CHECK(error.shift_px == 100);
    CHECK(error.pose_relative == 1);
}

TEST_CASE("the uncorrelated share of a map's error grows with the displacement between two maps",
          "[core]") {
    CHECK(uncorrelated_share(0) > 0.5f); // each map has noise of its own
    float before = uncorrelated_share(0);
    for (const float displacement : {0.001f, 0.01f, 0.1f, 1.0f}) {
        CHECK(uncorrelated_share(displacement) > before);
        before = uncorrelated_share(displacement);
    }
    CHECK(before < 1);
    CHECK(uncorrelated_share(100) == Approx(1).epsilon(1e-3));
}

TEST_CASE("the covariance by jitter of the lag agrees with Monte Carlo samples of exposure times",
          "[core]") {
    constexpr double jitter_s = 0.002;
    Twist then, now;
    then << 0.2, -0.1, 0.3, 0.5, -1.0, 0.2;
    now << -0.3, 0.4, 0.1, -0.8, 0.3, 0.6;
    const Pose pose = exp(Twist{{0.3, -0.2, 0.1, 0.2, 0.4, -0.3}});
    std::mt19937 random(1);
    std::normal_distribution<double> late(0, jitter_s);
    Eigen::Matrix<double, 6, 6> sampled = Eigen::Matrix<double, 6, 6>::Zero();
    constexpr int samples = 20000;
    for (int i = 0; i < samples; ++i) {
        // From where the camera was when the one map was exposed to where it is for the other.
        const Pose moved = exp(late(random) * now) * pose * exp(late(random) * then).inverse();
        const Twist misplaced = log(pose.inverse() * moved);
        sampled += misplaced * misplaced.transpose() / samples;
    }
    const Eigen::Matrix<double, 6, 6> covariance =
        lag_covariance(then, now, pose, jitter_s).cast<double>();
    CHECK((covariance - sampled).norm() < 0.03 * sampled.norm());
}
