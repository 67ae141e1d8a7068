// SPDX-License-Identifier: Apache-2.0
// What lenses, shutters and light do to the frames of two synthetic cameras.
#include "drivers/simulated/synthetic/exposure.hpp"
#include "drivers/simulated/synthetic/truth.hpp"
#include "tests/catch.hpp"
#include "tests/two_lenses.hpp"

#include <Eigen/Geometry>

#include <algorithm>
#include <cmath>

using namespace afterglow;
using namespace afterglow::testing;

TEST_CASE("the rows of a synthetic rolling shutter are exposed one after the other") {
    // The camera turns to the right by 40 degrees a second before an upright edge.
    constexpr double rate = 0.7, readout_s = 0.03;
    SyntheticWorld world = plain_wall(40);
    const int bright = add_plain_texture(world.scene, 200);
    world.scene.quads.push_back({.body = 0,
                                 .corner = {-3, -3, 1.99},
                                 .right = {1, 0, 0},
                                 .down = {0, 1, 0},
                                 .width = 3,
                                 .height = 6,
                                 .texture = bright});
    world.camera = [](double t) {
        return Pose{rotation({0, rate * t, 0.05}), Eigen::Vector3d::Zero()};
    };
    RigCalibration rig = two_lenses();
    rig.color.lens = Lens::pinhole;
    const auto edge_at = [&](double t, int v) {
        // Of the edge's points the one that row v sees.
        const Pose to_camera = world.camera(t).inverse();
        double low = -3, high = 3;
        for (int i = 0; i < 50; ++i) {
            const double y = (low + high) / 2;
            (rig.color.project(to_camera * Eigen::Vector3d(0, y, 1.99)).y() < v ? low : high) = y;
        }
        return rig.color.project(to_camera * Eigen::Vector3d(0, low, 1.99)).x();
    };
    for (const double readout : {0.0, readout_s}) {
        rig.readout_s = readout;
        const Luma luma = shoot(options_of(rig), world, 3).color.luma;
        double sum = 0, worst = 0;
        for (int v = 0; v < luma.height(); ++v) {
            double edge = -0.5;
            for (int u = 0; u < luma.width(); ++u)
                edge += (luma(u, v) - 40) / 160.0;
            const double t = 3 / 30.0 + readout * (v / 180.0 - 0.5);
            sum += edge - edge_at(t, v);
            worst = std::max(worst, std::abs(edge - edge_at(t, v)));
        }
        CHECK(std::abs(sum / luma.height()) < 0.02);
        CHECK(worst < 0.25); // a quarter of a pixel is what four samples tell apart
    }
    CHECK(std::abs(edge_at(0.1 - readout_s / 2, 0) - edge_at(0.1, 0)) >
          1); // so it is no small thing
}

TEST_CASE("synthetic depth is exposed later than its image by the rig's delay") {
    RigCalibration rig = two_lenses();
    for (const double delay : {-0.02, 0.0, 0.03}) {
        rig.tof_delay_s = delay;
        SyntheticOptions options = options_of(rig);
        options.motion = 3;
        SyntheticTruth truth(options);
        const Frame frame = shoot(options, make_world(options), 7);
        CHECK(frame.depth.t_ns == frame.color.t_ns);
        const auto share_of_equal = [&](double at) {
            const DepthMap there = truth.depth(7, rig.tof, rig.tof_from_color, {.delay_s = at});
            int equal = 0;
            for (std::size_t i = 0; i < there.pixels().size(); ++i)
                equal += std::abs(there.pixels()[i] - frame.depth.depth.pixels()[i]) <= 1;
            return equal / static_cast<double>(there.pixels().size());
        };
        CHECK(share_of_equal(delay) == 1);
        CHECK(share_of_equal(delay + 0.01) < 0.9);
    }
}

TEST_CASE("a lens that shows nothing at some pixels leaves them dark and without depth") {
    RigCalibration rig = two_lenses();
    rig.color.distortion = {-0.4, 0, 0, 0};
    rig.color.lens = rig.tof.lens = Lens::brown_conrady;
    rig.tof.distortion = {-0.8, 0, 0, 0};
    REQUIRE_FALSE(rig.tof.ray(0, 0));
    SyntheticOptions options = options_of(rig);
    options.multipath = 1;
    options.tof_exposure_ms = 5;
    const Frame frame = shoot(options, wall_world());
    const DepthMap truth =
        SyntheticTruth(options, wall_world()).depth(0, rig.tof, rig.tof_from_color);
    int dark = 0, wrong = 0;
    for (int v = 0; v < truth.height(); ++v) {
        for (int u = 0; u < truth.width(); ++u) {
            const bool shown = rig.tof.ray(u, v).has_value();
            dark += !shown;
            wrong += (truth(u, v) > 0) != shown || (frame.depth.depth(u, v) > 0) != shown ||
                     (frame.depth.amplitude(u, v) > 0) != shown;
        }
    }
    CHECK(wrong == 0);
    CHECK(dark > 100);
}

TEST_CASE("synthetic multipath lengthens what is near a concave corner, and nothing else") {
    // A box of 3 m, of which the far wall and the left one are seen.
    const auto depth_of = [](double multipath, bool corner) {
        SyntheticWorld world{.scene = {}, .camera = at_rest(), .tof = {}};
        const int texture = add_plain_texture(world.scene, 200);
        const int body = world.scene.add_body(at_rest());
        if (corner)
            world.scene.add_room(body, {0.5, 0, 0.5}, {3, 20, 3}, texture, texture, texture);
        else
            world.scene.add_box(body, {0, 0, 2}, {1, 1, 1}, texture);
        SyntheticOptions options = options_of(two_lenses());
        options.multipath = multipath;
        return shoot(options, world).depth.depth;
    };
    const DepthMap exact = depth_of(0, true), bent = depth_of(1, true),
                   stronger = depth_of(2, true);
    const int v = 87;
    const RigCalibration rig = two_lenses();
    const int corner =
        static_cast<int>(rig.tof.project(rig.tof_from_color * Eigen::Vector3d(-1, 0, 2)).x());
    int shorter = 0;
    for (std::size_t i = 0; i < exact.pixels().size(); ++i)
        shorter +=
            bent.pixels()[i] + 1 < exact.pixels()[i] || stronger.pixels()[i] + 1 < bent.pixels()[i];
    CHECK(shorter == 0);
    const auto longer = [&](const DepthMap &map, int u) { return map(u, v) - exact(u, v); };
    CHECK(longer(bent, corner - 9) > 20);
    CHECK(longer(bent, corner - 9) < 200);
    CHECK(longer(bent, corner + 15) > 5);
    CHECK(longer(stronger, corner - 9) > 1.5 * longer(bent, corner - 9));
    CHECK(longer(bent, 210) <= 1);
    // What bulges towards the camera sends it no light twice.
    CHECK(depth_of(1, false) == depth_of(0, false));
}

TEST_CASE("what moves while the synthetic TOF camera takes its phases smears at its edges") {
    const auto depth_of = [](double exposure_ms, double metres_per_s) {
        SyntheticWorld world = plain_wall(120);
        const int body = world.scene.add_body([metres_per_s](double t) {
            return Pose{Eigen::Matrix3d::Identity(), {metres_per_s * (t - 0.1), 0, 0}};
        });
        world.scene.add_box(body, {0, 0, 1.1}, {0.4, 0.4, 0.2}, 0);
        SyntheticOptions options = options_of(two_lenses());
        options.tof_exposure_ms = exposure_ms;
        return shoot(options, world, 3).depth.depth;
    };
    const auto differences = [](const DepthMap &a, const DepthMap &b) {
        int different = 0;
        for (std::size_t i = 0; i < a.pixels().size(); ++i)
            different += std::abs(a.pixels()[i] - b.pixels()[i]) > 2;
        return different;
    };
    const DepthMap still = depth_of(0, 0);
    CHECK(differences(still, depth_of(20, 0)) == 0);
    CHECK(differences(depth_of(0, 1), still) == 0); // at that moment it is there
    // 1 m/s in 15 ms between the first and the last phase at 1 m: 2 columns at each of two sides.
    const DepthMap moving = depth_of(20, 1);
    CHECK(differences(moving, still) > 80);
    CHECK(differences(moving, still) < 600);
    CHECK(std::abs(moving(110, 87) - still(110, 87)) <= 1);
}

TEST_CASE("synthetic exposure drifts and jumps within its stops, in images alone") {
    const Exposure exposure(5, 0.5);
    double least = 2, most = 0, biggest_step = 0;
    for (int k = 0; k < 3000; ++k) {
        const double factor = exposure.factor(k / 30.0);
        least = std::min(least, factor);
        most = std::max(most, factor);
        biggest_step =
            std::max(biggest_step, std::abs(std::log2(exposure.factor((k + 1) / 30.0) / factor)));
    }
    CHECK(least >= std::exp2(-0.5));
    CHECK(most <= std::exp2(0.5));
    CHECK(most / least > 1.3);
    CHECK(biggest_step > 0.1);

    SyntheticOptions changing = options_of(two_lenses());
    changing.exposure_changes = 1;
    SyntheticOptions steady = options_of(two_lenses());
    const SyntheticWorld world = plain_wall(100);
    const Frame changed = shoot(changing, world, 20), plain = shoot(steady, world, 20);
    const double factor = Exposure(changing.seed, 1).factor(20 / 30.0);
    REQUIRE(std::abs(factor - 1) > 0.02);
    CHECK(changed.color.luma(100, 100) == std::lround(factor * plain.color.luma(100, 100)));
    CHECK(changed.depth.depth == plain.depth.depth);
    CHECK(changed.depth.amplitude == plain.depth.amplitude);
    // One camera changes its exposure, too.
    const SyntheticOptions one{
        .width = 64, .height = 48, .real_time = false, .noise = false, .exposure_changes = 1};
    CHECK(shoot(one, world, 20).color.luma(30, 20) == std::lround(factor * 100));
}

TEST_CASE("synthetic amplitude is the light that comes back") {
    SyntheticOptions options = options_of(two_lenses());
    const Frame frame = shoot(options, plain_wall(255));
    const CameraModel &tof = options.rig->tof;
    for (int v = 0; v < 172; v += 9) {
        for (int u = 0; u < 224; u += 9) {
            const double z = frame.depth.depth(u, v) / 1000.0;
            const double square = z * z * tof.ray(u, v)->homogeneous().squaredNorm();
            CHECK(frame.depth.amplitude(u, v) == Approx(4095 / square).epsilon(0.01));
        }
    }
    options.noise = true;
    const Frame noisy = shoot(options, plain_wall(255));
    double squares = 0;
    const auto pixels = noisy.depth.amplitude.pixels();
    for (std::size_t i = 0; i < pixels.size(); ++i) {
        const double light = frame.depth.amplitude.pixels()[i];
        squares += (pixels[i] - light) * (pixels[i] - light) / light;
    }
    CHECK(squares / static_cast<double>(pixels.size()) == Approx(1).epsilon(0.05));
}
