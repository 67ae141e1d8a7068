// SPDX-License-Identifier: Apache-2.0
#include "eval/rigs/rig_footage.hpp"
#include "eval/rigs/rig_sweep.hpp"
#include "tests/catch.hpp"

#include <algorithm>
#include <set>

using namespace afterglow;

namespace {

/// Small cameras 8 cm apart that look the same way.
RigGeometry wide_pair(bool publishes_tof) {
    RigCalibration rig;
    rig.color.pinhole = {60, 60, 79.5, 59.5, 160, 120};
    rig.tof.pinhole = {75, 75, 47.5, 35.5, 96, 72};
    rig.tof_from_color.T = {-0.08, 0, 0};
    return publishes_tof ? RigGeometry(rig, rig.tof, rig.tof_from_color)
                         : RigGeometry(rig, rig.color, {});
}

} // namespace

TEST_CASE("the sweep of rigs has each pair of cameras at each distance with each view") {
    const auto all = select_rigs({});
    CHECK(all.size() == 81);
    std::set<std::vector<std::string>> different;
    for (const SweptRig &rig : all) {
        different.insert(rig.words());
        const RigGeometry geometry = rig.geometry();
        CHECK(geometry.rig.tof_from_color.T.norm() ==
              Approx(0.001 * rig.baseline_mm).epsilon(0.01));
        CHECK(geometry.publishes_color() == (rig.published == "color"));
        CHECK(geometry.publishes_readings() == (rig.published == "tof"));
        // Lenses show something in all of their pictures.
        for (const CameraModel &camera : {geometry.rig.color, geometry.rig.tof})
            for (const double u : {0.0, camera.pinhole.width - 1.0})
                for (const double v : {0.0, camera.pinhole.height - 1.0})
                    CHECK(camera.ray(u, v));
    }
    CHECK(different.size() == 81);
    // The wide one: 110 degrees from side to side.
    const CameraModel &wide = swept_color_cameras().back().model;
    const auto left = wide.ray(0, 540), right = wide.ray(1919, 540);
    CHECK(std::atan(right->x()) - std::atan(left->x()) ==
          Approx(110 * 3.14159265 / 180).margin(0.03));
}

TEST_CASE("rigs are selected by words, of each kind one of those named") {
    CHECK(select_rigs({"25mm"}).size() == 27);
    CHECK(select_rigs({"25mm", "80mm", "tof"}).size() == 18);
    const auto one = select_rigs({"224x172", "1280x720", "5mm", "own"});
    REQUIRE(one.size() == 1);
    CHECK(one[0].words() == std::vector<std::string>{"224x172", "1280x720", "5mm", "own"});
    CHECK(sweep_words().size() == 12);
}

TEST_CASE("the coverage of a rig counts what its TOF camera can see, and nothing else") {
    const SyntheticOptions options{.noise = false};
    for (const bool publishes_tof : {false, true}) {
        const RigGeometry geometry = wide_pair(publishes_tof);
        RigTruth truth(options, geometry);
        const DepthMap all = truth.depth(5);
        const int w = all.width(), h = all.height();
        CHECK(truth.coverage(5, all) == 100.0);
        CHECK(truth.coverage(5, DepthMap(w, h)) == 0.0);
        // What it can see at all: in its own picture everything, in a wider one the middle.
        DepthMap border = all, middle = all;
        for (int v = 0; v < h; ++v)
            for (int u = 0; u < w; ++u) {
                const bool outside = u < w / 8 || u >= w - w / 8;
                (outside ? middle : border)(u, v) = 0;
            }
        if (publishes_tof) {
            CHECK(*truth.coverage(5, border) == Approx(25).margin(2));
        } else {
            CHECK(truth.coverage(5, border) == 0.0);
            CHECK(truth.coverage(5, middle) == 100.0);
        }
    }
}

TEST_CASE("a rig whose colour camera sees behind a thing does not ask its TOF camera for that") {
    const RigGeometry geometry = wide_pair(false);
    RigTruth truth(SyntheticOptions{.noise = false}, geometry);
    // Whatever only the colour camera sees beside near things is what keeps this below the share
    // of pixels that are in the TOF camera's picture.
    const DepthMap all = truth.depth(0);
    SyntheticOptions options{.noise = false, .rig = geometry.rig};
    SyntheticTruth direct(options);
    const DepthMap tof = direct.depth(0, geometry.rig.tof, geometry.rig.tof_from_color);
    // Take away each pixel whose point is hidden from the TOF camera: coverage stays whole.
    DepthMap seen = all;
    int hidden = 0;
    for (int v = 0; v < all.height(); ++v)
        for (int u = 0; u < all.width(); ++u) {
            const Eigen::Vector3d X =
                geometry.rig.tof_from_color *
                geometry.rig.color.pinhole.back_project(u, v, 0.001 * all(u, v));
            const Eigen::Vector2d at = geometry.rig.tof.project(X);
            const int x = static_cast<int>(std::lround(at.x()));
            const int y = static_cast<int>(std::lround(at.y()));
            if (tof.view().contains(x, y) && 1000 * X.z() > 1.1 * tof(x, y)) {
                seen(u, v) = 0;
                ++hidden;
            }
        }
    REQUIRE(hidden > 20);
    CHECK(truth.coverage(0, seen) == 100.0);
}
