// SPDX-License-Identifier: Apache-2.0
#include "core/gate.hpp"
#include "drivers/simulated/synthetic/noise.hpp"
#include "eval/scoring/metrics.hpp"
#include "tests/catch.hpp"
#include "tests/film.hpp"

#include <cmath>

using namespace afterglow;
using namespace afterglow::testing;

namespace {

constexpr int frames = 10'000;

} // namespace

TEST_CASE("the keyframe pipeline of a static camera does not drift and lights only at the longest "
          "interval",
          "[core]") {
    const Film scene = film_room(160, 120, 1, 0);
    const Noise noise(1, TofNoise::none());
    Viewer viewer(scene);
    Gate gate{GatePolicy{}};
    Luma image = scene.images[0];
    int lit = 0;
    Eigen::Vector3d early = Eigen::Vector3d::Zero(); // sums of where the camera seems to be
    Eigen::Vector3d late = Eigen::Vector3d::Zero();
    double furthest_m = 0;
    double furthest_rad = 0;
    double worst_mre = 0;
    double worst_coverage = 100;
    for (int k = 0; k < frames; ++k) {
        image = scene.images[0];
        noise.add_to(static_cast<std::uint64_t>(k), image);
        const Estimate &estimate = viewer.track(image);
        if (gate.wants_light(estimate)) {
            ++lit;
            viewer.measure(0);
            gate.measured();
            continue;
        }
        (k < frames / 2 ? early : late) += estimate.pose.T;
        furthest_m = std::max(furthest_m, estimate.pose.T.norm());
        furthest_rad = std::max(furthest_rad, estimate.pose.angle());
        if (k % 100 != 99)
            continue;
        const DepthErrors errors = compare_depth(estimate.depth, scene.depth[0]);
        worst_mre = std::max(worst_mre, errors.mre);
        worst_coverage = std::min(worst_coverage, errors.coverage());
    }
    const int longest = GatePolicy{}.longest_interval_frames;
    // Once each longest interval, and once more while the expected error is still being learnt.
    CHECK(lit <= (frames + longest - 1) / longest + 1);
    // The two halves rest on 17 measured images each, whose noise does not average out further.
    CHECK((late - early).norm() / (0.5 * frames) < 0.001);
    // Around that place it jitters, after all frames no more than after one: noise of 1.5 grey
    // values on 160 x 120 pixels, the worst of ten thousand images.
    CHECK(furthest_m < 0.01);
    CHECK(furthest_rad < 0.004);
    CHECK(worst_mre < 0.3);
    CHECK(worst_coverage > 90);
}
