// SPDX-License-Identifier: Apache-2.0
#include "drivers/simulated/synthetic/exposure.hpp"
#include "drivers/simulated/synthetic/synthetic.hpp"
#include "drivers/simulated/synthetic/truth.hpp"
#include "tests/allocation_count.hpp"
#include "tests/catch.hpp"

#include <algorithm>
#include <cmath>
#include <optional>
#include <utility>
#include <vector>

using namespace afterglow;
using namespace std::chrono_literals;

namespace {

/// 110 degrees from side to side.
const CameraModel fisheye{.pinhole = {170, 170, 161, 88, 320, 180},
                          .lens = Lens::kannala_brandt,
                          .distortion = {-0.02, 0.003, -0.001, 0.0002}};
const CameraModel barrel{.pinhole = {150, 152, 110, 87, 224, 172},
                         .lens = Lens::brown_conrady,
                         .distortion = {-0.25, 0.07, 0.001, -0.0008, 0.004, 0.01, 0.002, 0}};

/// A fisheye, and a TOF camera 3 cm beside it that looks a little elsewhere.
RigCalibration two_lenses() {
    return {.color = fisheye,
            .tof = barrel,
            .tof_from_color = {rotation({0.01, -0.02, 0.015}), {-0.03, 0.002, 0.001}}};
}

SyntheticOptions options_of(const RigCalibration &rig) {
    return {.real_time = false, .noise = false, .rig = rig};
}

/// A wall 2 m before a camera at rest.
SyntheticWorld wall_world() {
    SyntheticWorld world{.scene = {}, .camera = at_rest(), .tof = {}};
    const int body = world.scene.add_body(at_rest());
    world.scene.add_wall(body, 2, 100, world.scene.add_texture(make_texture(Pattern::print, 1)));
    return world;
}

int add_plain_texture(Scene &scene, std::uint8_t luma) {
    return scene.add_texture(Texture(
        std::vector<std::uint8_t>(static_cast<std::size_t>(Texture::size) * Texture::size, luma)));
}

/// A wall 2 m away, of one colour.
SyntheticWorld plain_wall(std::uint8_t luma) {
    SyntheticWorld world{.scene = {}, .camera = at_rest(), .tof = {}};
    const int texture = add_plain_texture(world.scene, luma);
    world.scene.add_wall(world.scene.add_body(at_rest()), 2, 100, texture);
    return world;
}

struct Frame {
    ColorFrame color;
    DepthFrame depth;
};

/// Image k and its measured depth.
Frame shoot(const SyntheticOptions &options, const SyntheticWorld &world, int k = 0) {
    auto rig = open_synthetic(options, world);
    REQUIRE(rig);
    REQUIRE(rig->color->start());
    REQUIRE(rig->tof->start());
    REQUIRE(rig->illuminator->set(true));
    Frame frame;
    const Intrinsics &color = rig->color->intrinsics();
    const Intrinsics &tof = rig->tof->intrinsics();
    frame.color.luma = Luma(color.width, color.height);
    frame.depth.depth = DepthMap(tof.width, tof.height);
    for (int i = 0; i <= k; ++i)
        REQUIRE(rig->color->read(frame.color, 0ns) == Capture::frame);
    REQUIRE(rig->tof->read(frame.depth, 0ns) == Capture::frame);
    return frame;
}

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
