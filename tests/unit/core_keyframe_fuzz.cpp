// SPDX-License-Identifier: Apache-2.0
//
// Nothing that a camera can send makes preset "default" say something that is not a number.
#include "core/error/expected_error.hpp"
#include "tests/catch.hpp"
#include "tests/film.hpp"

#include <cmath>
#include <random>
#include <utility>

using namespace afterglow;
using namespace afterglow::testing;

namespace {

constexpr std::uint16_t far_away = 65535;

std::vector<Luma> bad_images(int w, int h) {
    std::vector<Luma> images{Luma(w, h, 0), Luma(w, h, 255), Luma(w, h, 128)};
    std::mt19937 random(1);
    Luma noise(w, h);
    for (std::uint8_t &pixel : noise.pixels())
        pixel = static_cast<std::uint8_t>(random());
    images.push_back(noise);
    for (const int square : {1, 2, 7, 16}) {
        Luma board(w, h);
        for (int v = 0; v < h; ++v)
            for (int u = 0; u < w; ++u)
                board(u, v) = (u / square + v / square) % 2 ? 255 : 0;
        images.push_back(board);
    }
    Luma ramp(w, h);
    for (int v = 0; v < h; ++v)
        for (int u = 0; u < w; ++u)
            ramp(u, v) = static_cast<std::uint8_t>(255 * u / w);
    images.push_back(ramp);
    return images;
}

std::vector<DepthMap> bad_depth(int w, int h) {
    std::vector<DepthMap> maps{DepthMap(w, h, 0), DepthMap(w, h, far_away), DepthMap(w, h, 1),
                               DepthMap(w, h, 100), DepthMap(w, h, 2000)};
    std::mt19937 random(2);
    DepthMap salt_and_pepper(w, h, 1500);
    for (std::uint16_t &z : salt_and_pepper.pixels())
        if (const auto dice = random() % 8; dice < 2)
            z = dice == 0 ? 0 : far_away;
    maps.push_back(salt_and_pepper);
    DepthMap noise(w, h);
    for (std::uint16_t &z : noise.pixels())
        z = static_cast<std::uint16_t>(random());
    maps.push_back(noise);
    DepthMap alternating(w, h);
    for (int v = 0; v < h; ++v)
        for (int u = 0; u < w; ++u)
            alternating(u, v) = (u + v) % 2 ? 500 : 8000;
    maps.push_back(alternating);
    DepthMap one_pixel(w, h, 0);
    one_pixel(w / 2, h / 2) = 1000;
    maps.push_back(one_pixel);
    return maps;
}

bool is_share(float percent) {
    return percent >= 0 && percent <= 100;
}

/// Every number is one, and depth, confidence and coverage agree with each other.
void check_sane(const Estimate &e) {
    CHECK(e.pose.is_finite());
    CHECK((e.pose.R * e.pose.R.transpose() - Eigen::Matrix3d::Identity()).norm() < 1e-9);
    CHECK(std::isfinite(e.expected_mre));
    CHECK(e.expected_mre >= 0);
    CHECK(std::isfinite(e.independent_mre));
    CHECK(e.independent_mre >= e.expected_mre);
    CHECK(std::isfinite(e.fresh_mre));
    CHECK(e.fresh_mre >= 0);
    CHECK(is_share(e.coverage));
    CHECK(is_share(e.relative_coverage));
    CHECK(e.inliers >= 0);
    CHECK(e.inliers <= e.matches);
    int covered = 0;
    int at_odds = 0;
    int measured = 0;
    for (int v = 0; v < e.depth.height(); ++v)
        for (int u = 0; u < e.depth.width(); ++u) {
            covered += e.depth(u, v) != 0;
            at_odds += (e.depth(u, v) != 0) != (e.confidence(u, v) != 0);
            measured += e.confidence(u, v) == measured_confidence;
        }
    CHECK(at_odds == 0);
    if (!e.depth.empty()) // else it is that of the last map
        CHECK(e.coverage == Approx(100.0 * covered / (e.depth.width() * e.depth.height())));
    if (e.source != FrameSource::measured)
        CHECK(measured == 0);
    if (e.source == FrameSource::none)
        CHECK(covered == 0);
}

void fuzz(int w, int h) {
    Film scene = film_room(w, h, 2);
    std::vector<Luma> images = bad_images(w, h);
    std::vector<DepthMap> depth = bad_depth(w, h);
    images.insert(images.end(), scene.images.begin(), scene.images.end());
    depth.push_back(scene.depth[0]);
    // Every map with every image, and every image after every other.
    Viewer through(scene);
    for (std::size_t i = 0; i < images.size(); ++i)
        for (std::size_t d = 0; d < depth.size(); ++d) {
            INFO("image " << i << ", depth " << d);
            Viewer fresh(scene);
            through.want_depth((i + d) % 3 != 0);
            for (Viewer *viewer : {&fresh, &through}) {
                check_sane(viewer->track(images[i]));
                check_sane(viewer->measure(depth[d]));
                check_sane(viewer->track(images[i]));
                check_sane(viewer->track(images[(i + d) % images.size()]));
            }
        }
}

} // namespace

TEST_CASE("the keyframe pipeline gives no NaN for random images and depth maps", "[core]") {
    fuzz(160, 120);
}

TEST_CASE("the keyframe pipeline gives no NaN for images of odd width and height", "[core]") {
    fuzz(97, 61);
}

TEST_CASE("the keyframe pipeline composes several maps at any image size", "[core]") {
    // Square ones, and just below where a grid of samples would be coarser.
    const auto [width, height] =
        GENERATE(std::pair(95, 95), std::pair(143, 143), std::pair(64, 48));
    const Film scene = film_room(width, height, 12, 4);
    Viewer viewer(scene);
    for (std::size_t k = 0; k < scene.images.size(); ++k) {
        check_sane(viewer.track(scene.images[k]));
        if (k % 4 == 0)
            check_sane(viewer.measure(scene.depth[k]));
    }
}

TEST_CASE("the keyframe pipeline gives no NaN for timestamps that repeat or jump", "[core]") {
    const Film scene = film_room(160, 120, 4);
    WorkerPool pool(1);
    const auto pipeline = pipeline_factory({}, pool)(scene.camera);
    std::int64_t t = 0;
    for (const std::int64_t gap : {0l, 1l, 33'000'000l, 0l, 1'000'000'000'000'000'000l, 1l}) {
        t += gap;
        for (std::size_t k = 0; k < scene.images.size(); ++k) {
            check_sane(pipeline->track(scene.images[k], t));
            if (k == 1)
                check_sane(pipeline->measure(scene.depth[k]));
        }
    }
}
