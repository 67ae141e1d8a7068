// SPDX-License-Identifier: Apache-2.0
#include "drivers/simulated/synthetic/synthetic.hpp"
#include "drivers/simulated/synthetic/truth.hpp"
#include "tests/allocation_count.hpp"
#include "tests/catch.hpp"
#include "tests/two_lenses.hpp"

#include <Eigen/Geometry>

#include <algorithm>
#include <cmath>
#include <optional>
#include <utility>

using namespace afterglow;
using namespace afterglow::testing;
using namespace std::chrono_literals;

namespace {

/// The largest distance between a map and what `z_at` says of the ray (x, y, 1), millimetres, over
/// pixels where both see something; counts those.
template <class ZAt>
double worst_mm(const DepthMap &depth, const CameraModel &camera, ZAt z_at, int &compared) {
    double worst = 0;
    compared = 0;
    for (int v = 0; v < depth.height(); ++v) {
        for (int u = 0; u < depth.width(); ++u) {
            const auto ray = camera.ray(u, v);
            if (!ray || depth(u, v) == 0)
                continue;
            const std::optional<double> z = z_at(ray->homogeneous().eval());
            if (!z)
                continue;
            worst = std::max(worst, std::abs(depth(u, v) - 1000 * *z));
            ++compared;
        }
    }
    return worst;
}

/// Where a bright thing before a dark wall is seen: the centre of what is brighter than the wall.
Eigen::Vector2d centre_of_light(const Luma &luma, int dark) {
    Eigen::Vector2d sum(0, 0);
    double weight = 0;
    for (int v = 0; v < luma.height(); ++v) {
        for (int u = 0; u < luma.width(); ++u) {
            const double light = std::max(0, luma(u, v) - dark);
            sum += light * Eigen::Vector2d(u, v);
            weight += light;
        }
    }
    REQUIRE(weight > 0);
    return sum / weight;
}

template <class Pixel>
double fingerprint(const Image<Pixel> &image) {
    double sum = 0;
    std::size_t i = 0;
    for (const Pixel pixel : image.pixels())
        sum += pixel * static_cast<double>(i++ % 97 + 1);
    return sum / static_cast<double>(i);
}

} // namespace

TEST_CASE("a synthetic camera with registered depth gives the frames that it always gave") {
    const SyntheticOptions options{.width = 160, .height = 120, .seed = 2, .real_time = false};
    const Frame frame = shoot(options, make_world(options), 39);
    SyntheticTruth truth(options);
    CHECK(fingerprint(frame.color.luma) == Approx(6469.6257291667).epsilon(1e-6));
    CHECK(fingerprint(frame.depth.depth) == Approx(132623.07359375).epsilon(1e-6));
    CHECK(fingerprint(truth.luma(39)) == Approx(6468.7600520833).epsilon(1e-6));
    CHECK(fingerprint(truth.depth(39)) == Approx(132609.4052083333).epsilon(1e-6));
    CHECK(frame.depth.amplitude.empty());
}

TEST_CASE("synthetic depth through a lens is that of a plane and a sphere met by its rays") {
    SyntheticWorld world = wall_world();
    const Pose color_to_world{rotation({0.1, 0.2, 0.1}), {0.3, -0.2, 0.4}};
    world.camera = at_rest(color_to_world);
    const Eigen::Vector3d ball(0.4, 0, 1.6);
    constexpr double radius = 0.25;
    world.scene.spheres.push_back({.body = 0, .center = ball, .radius = radius});
    RigCalibration rig = two_lenses();
    for (const bool along_ray : {false, true}) {
        rig.range_along_ray = along_ray;
        SyntheticTruth truth(options_of(rig), world);
        const DepthMap measured = shoot(options_of(rig), world).depth.depth;
        const Pose world_from_tof = color_to_world * rig.tof_from_color.inverse();
        struct View {
            const DepthMap &depth;
            const CameraModel &camera;
            Pose to_world;
            bool along_ray;
        };
        const DepthMap color = truth.depth(0);
        const DepthMap tof = truth.depth(0, rig.tof, rig.tof_from_color);
        for (const View &view : {View{color, rig.color, color_to_world, false},
                                 View{tof, rig.tof, world_from_tof, false},
                                 View{measured, rig.tof, world_from_tof, along_ray}}) {
            int on_wall = 0, on_ball = 0;
            const auto hits_ball = [&](const Eigen::Vector3d &d) -> std::optional<double> {
                const Eigen::Vector3d c = view.to_world.inverse() * ball;
                const double b = d.dot(c), dd = d.squaredNorm();
                const double root = b * b - dd * (c.squaredNorm() - radius * radius);
                if (root < 0)
                    return std::nullopt;
                return (b - std::sqrt(root)) / dd * (view.along_ray ? d.norm() : 1);
            };
            const auto hits_wall = [&](const Eigen::Vector3d &d) -> std::optional<double> {
                if (hits_ball(d))
                    return std::nullopt;
                const double z = (2 - view.to_world.T.z()) / (view.to_world.R * d).z();
                return z * (view.along_ray ? d.norm() : 1);
            };
            CHECK(worst_mm(view.depth, view.camera, hits_wall, on_wall) < 0.52);
            // Rays are stored as floats: on the outline a sphere is steep.
            CHECK(worst_mm(view.depth, view.camera, hits_ball, on_ball) < 1.1);
            CHECK(on_ball > 200);
            CHECK(on_wall + on_ball == view.depth.width() * view.depth.height());
        }
    }
}

TEST_CASE("both synthetic cameras see one point where their calibration says") {
    SyntheticWorld world = plain_wall(40);
    const int bright = add_plain_texture(world.scene, 200);
    // A card, turned so that its sides are no rows and columns.
    const Eigen::Vector3d centre(0.12, 0.17, 1.3);
    const int card = world.scene.add_body(at_rest({rotation({0, 0, 0.4}), centre}));
    world.scene.add_wall(card, 0, 0.06, bright);
    RigCalibration rig = two_lenses();
    const Frame frame = shoot(options_of(rig), world);
    const Eigen::Vector2d in_color = centre_of_light(frame.color.luma, 40);
    CHECK((in_color - rig.color.project(centre)).norm() < 0.05);

    // The TOF camera's own image: what the colour camera would see in its place.
    RigCalibration turned = rig;
    std::swap(turned.color, turned.tof);
    SyntheticWorld seen_by_tof = world;
    seen_by_tof.camera = at_rest(rig.tof_from_color.inverse());
    const Luma luma = shoot(options_of(turned), seen_by_tof).color.luma;
    const Eigen::Vector2d where = rig.tof.project(rig.tof_from_color * centre);
    CHECK((centre_of_light(luma, 40) - where).norm() < 0.05);

    // And its amplitude shows the ball at the same place.
    Luma of_light(luma.width(), luma.height());
    const auto &amplitude = frame.depth.amplitude;
    REQUIRE(amplitude.view().same_size(of_light.view()));
    for (std::size_t i = 0; i < of_light.pixels().size(); ++i)
        of_light.pixels()[i] = static_cast<std::uint8_t>(std::min(amplitude.pixels()[i] / 10, 255));
    const int most_of_wall = 4095 * 40 / 255 / 4 / 10 + 1;
    CHECK((centre_of_light(of_light, most_of_wall) - where).norm() < 0.2);
}

TEST_CASE("two synthetic cameras with every error allocate nothing in steady state") {
    SyntheticOptions options = options_of(two_lenses());
    options.noise = true;
    options.rig->readout_s = 0.02;
    options.exposure_changes = options.multipath = 1;
    options.tof_exposure_ms = 5;
    auto rig = open_synthetic(options);
    REQUIRE(rig);
    REQUIRE(rig->color->start());
    REQUIRE(rig->tof->start());
    REQUIRE(rig->illuminator->set(true));
    ColorFrame color{Luma(320, 180)};
    DepthFrame depth{DepthMap(224, 172)};
    bool good = rig->color->read(color, 0ns) == Capture::frame &&
                rig->tof->read(depth, 0ns) == Capture::frame;
    const auto before = allocation_count();
    for (int k = 0; k < 5; ++k) {
        good = good && rig->color->read(color, 0ns) == Capture::frame;
        good = good && rig->tof->read(depth, 0ns) == Capture::frame;
    }
    CHECK(allocation_count() == before);
    CHECK(good);
}

TEST_CASE("rigs that cannot be are refused") {
    const auto refused = [](auto change) {
        SyntheticOptions options = options_of(two_lenses());
        change(options);
        const auto rig = open_synthetic(options);
        return !rig && !rig.error().message.empty();
    };
    CHECK_FALSE(refused([](SyntheticOptions &) {}));
    CHECK(refused([](SyntheticOptions &o) { o.rig->color.pinhole.width = 0; }));
    CHECK(refused([](SyntheticOptions &o) { o.rig->tof.pinhole.height = 5000; }));
    CHECK(refused([](SyntheticOptions &o) { o.rig->tof.pinhole.fx = 0; }));
    CHECK(refused([](SyntheticOptions &o) { o.rig->color.pinhole.fy = std::nan(""); }));
    CHECK(refused([](SyntheticOptions &o) { o.rig->color.distortion[0] = std::nan(""); }));
    CHECK(refused([](SyntheticOptions &o) { o.rig->tof_from_color.R(0, 1) += 0.1; }));
    CHECK(refused([](SyntheticOptions &o) { o.rig->tof_from_color.T.x() = std::nan(""); }));
    CHECK(refused([](SyntheticOptions &o) { o.rig->readout_s = -0.01; }));
    CHECK(refused([](SyntheticOptions &o) { o.rig->tof_delay_s = 2; }));
    CHECK(refused([](SyntheticOptions &o) { o.multipath = -1; }));
    CHECK(refused([](SyntheticOptions &o) { o.exposure_changes = 5; }));
    CHECK(refused([](SyntheticOptions &o) { o.tof_exposure_ms = std::nan(""); }));
}
