// SPDX-License-Identifier: Apache-2.0
//
// Depth that the sensor cannot see now but saw before is filled in: Noraky & Sze 2019's Section
// VIII and its two figures, 0.87 % out of range and 0.6 % where the sensor saturates.
#include "core/error/expected_error.hpp"
#include "drivers/files/image_file.hpp"
#include "drivers/files/recording.hpp"
#include "drivers/simulated/synthetic/noise.hpp"
#include "eval/report/paper_figures.hpp"
#include "eval/scoring/metrics.hpp"
#include "tests/catch.hpp"
#include "tests/film.hpp"
#include "tests/skip.hpp"

#include <functional>
#include <optional>
#include <string>

using namespace afterglow;
using namespace afterglow::testing;

namespace {

using paper::out_of_range_mre, paper::saturation_mre;

/// Says of a pixel and its depth whether the sensor is blind to it.
using Blind = std::function<bool(int u, int v, int z)>;

struct Infill {
    DepthErrors filled;      ///< of what was blind and is filled
    DepthErrors overlap;     ///< of the estimate before, where the sensor sees (the paper's figure)
    int blind = 0;           ///< pixels
    int wrong_flags = 0;     ///< filled pixels that claim to be measured, or seen ones that do not
    float coverage = 0;      ///< percent, of what is published for the measured frame
    float next_coverage = 0; ///< and for the one after
};

/// The first frame of `sensor` is measured as it is, the last without what `blind` takes. `truth`:
/// of the last frame.
Infill infill(const Film &sensor, const DepthMap &truth, const Blind &blind) {
    const int last = static_cast<int>(sensor.images.size()) - 1;
    EstimatorOptions options;
    options.keyframe.compose.maps_per_frame = 3; // for the frames after the measured one
    Viewer viewer(sensor, options);
    viewer.track(0);
    viewer.measure(0);
    for (int k = 1; k < last; ++k)
        viewer.track(k);
    Infill result;
    const DepthMap &full = sensor.depth.back();
    DepthMap cut = full;
    DepthMap seen_truth = truth;
    DepthMap blind_truth(full.width(), full.height());
    for (int v = 0; v < full.height(); ++v)
        for (int u = 0; u < full.width(); ++u)
            if (full(u, v) != 0 && blind(u, v, full(u, v))) {
                cut(u, v) = 0;
                std::swap(seen_truth(u, v), blind_truth(u, v));
                ++result.blind;
            }
    result.overlap = compare_depth(viewer.track(last).depth, seen_truth);
    const Estimate &measured = viewer.measure(cut);
    REQUIRE(measured.source == FrameSource::measured);
    result.filled = compare_depth(measured.depth, blind_truth);
    result.coverage = measured.coverage;
    for (int v = 0; v < full.height(); ++v)
        for (int u = 0; u < full.width(); ++u) {
            const bool seen = cut(u, v) != 0;
            result.wrong_flags += seen != (measured.confidence(u, v) == measured_confidence);
            result.wrong_flags += seen && measured.depth(u, v) != cut(u, v);
        }
    result.next_coverage = viewer.track(last).coverage;
    return result;
}

Blind further_than(int mm) {
    return [mm](int, int, int z) { return z > mm; };
}

/// The middle of the picture is too near.
Blind saturated(const Intrinsics &camera) {
    return [camera](int u, int v, int) {
        const double x = (u - camera.cx) / camera.width;
        const double y = (v - camera.cy) / camera.height;
        return x * x + y * y < 0.04;
    };
}

/// The depth that half of the pixels are nearer than.
int median_depth(const DepthMap &depth) {
    std::vector<std::uint16_t> known;
    for (const std::uint16_t z : depth.pixels())
        if (z != 0)
            known.push_back(z);
    const auto middle = known.begin() + static_cast<std::ptrdiff_t>(known.size() / 2);
    std::nth_element(known.begin(), middle, known.end());
    return *middle;
}

void check(const Infill &result, double most_mre, double least_filled) {
    INFO(result.filled.pixels << " of " << result.blind << " filled, MRE " << result.filled.mre
                              << " %; overlap " << result.overlap.mre << " %");
    CHECK(result.blind > 1000);
    CHECK(result.filled.mre <= most_mre);
    CHECK(result.overlap.mre <= most_mre);
    CHECK(static_cast<double>(result.filled.pixels) > least_filled * result.blind);
    CHECK(result.wrong_flags == 0);
    // What was filled in is not forgotten with the next image.
    CHECK(result.next_coverage > result.coverage - 5);
}

/// The synthetic room, exact and through a noisy TOF camera, moved along its axis at so many metres
/// a second.
struct Walk {
    Film exact;
    Film sensor;
};

Walk walk(double along) {
    const SyntheticOptions options{.width = 320, .height = 240};
    SyntheticWorld world = make_world(options);
    world.camera = [along](double t) {
        return Pose{Eigen::Matrix3d::Identity(), {0, 0, along * t}};
    };
    Walk walk{film(options, world, 16), {}};
    walk.sensor = walk.exact;
    const Noise noise(1, {.nearest = 0.1, .furthest = 20, .flying = 0});
    for (std::size_t k = 0; k < walk.exact.depth.size(); ++k) {
        Image<float> z(320, 240);
        for (std::size_t i = 0; i < z.pixels().size(); ++i)
            z.pixels()[i] = 0.001f * static_cast<float>(walk.exact.depth[k].pixels()[i]);
        noise.measure(k, z.view(), walk.exact.images[k], walk.sensor.depth[k]);
        noise.add_to(k, walk.sensor.images[k]);
    }
    return walk;
}

/// Ten frames of a recording; nothing, and the test case counts as skipped, when it is missing.
std::optional<Film> recorded(const std::string &name) {
    const auto folder = recording_or_skip(name);
    if (!folder)
        return std::nullopt;
    const auto recording = open_recording(*folder);
    REQUIRE(recording);
    Film seen{recording->camera, {}, {}};
    for (std::size_t k = 0; k < 10; ++k) {
        auto image = read_luma(recording->entries[k].color_path);
        REQUIRE(image);
        seen.images.push_back(*std::move(image));
        seen.depth.emplace_back(seen.camera.width, seen.camera.height);
        REQUIRE(read_depth_mm(*recording, k, seen.depth.back()));
    }
    return seen;
}

} // namespace

TEST_CASE("keyframe infill fills depth beyond the range (synthetic)", "[core]") {
    const Walk back = walk(-0.3);
    const DepthMap &truth = back.exact.depth.back();
    check(infill(back.sensor, truth, further_than(median_depth(truth))), out_of_range_mre, 0.75);
}

TEST_CASE("keyframe infill fills saturated depth (synthetic)", "[core]") {
    const Walk forth = walk(0.3);
    check(infill(forth.sensor, forth.exact.depth.back(), saturated(forth.sensor.camera)),
          saturation_mre, 0.9);
}

TEST_CASE("keyframe infill fills depth beyond the range (real recording)", "[core]") {
    if (const auto seen = recorded("7scenes_redkitchen")) {
        const DepthMap &truth = seen->depth.back();
        check(infill(*seen, truth, further_than(median_depth(truth))), out_of_range_mre, 0.6);
    }
}

TEST_CASE("keyframe infill fills saturated depth (real recording)", "[core]") {
    if (const auto seen = recorded("7scenes_redkitchen"))
        check(infill(*seen, seen->depth.back(), saturated(seen->camera)), saturation_mre, 0.6);
}

TEST_CASE("keyframe infill invents no depth that no map has measured", "[core]") {
    const Film room = film_room(160, 120, 1);
    Viewer viewer(room);
    viewer.track(0);
    DepthMap half = room.depth[0];
    for (int v = 0; v < half.height(); ++v)
        std::fill(half.row(v), half.row(v) + half.width() / 2, std::uint16_t{0});
    const Estimate &first = viewer.measure(half);
    CHECK(std::equal(half.pixels().begin(), half.pixels().end(), first.depth.data()));
    viewer.track(0);
    const Estimate &again = viewer.measure(half);
    int invented = 0; // but the crack-wide rim of the known half
    for (int v = 0; v < half.height(); ++v)
        for (int u = 0; u < half.width() / 2 - 4; ++u)
            invented += again.depth(u, v) != 0;
    CHECK(invented == 0);
}
