// SPDX-License-Identifier: Apache-2.0
#include "core/moving/image_patch.hpp"
#include "tests/catch.hpp"
#include "tests/instruction_set.hpp"

#include <Eigen/LU>

#include <algorithm>
#include <cmath>
#include <limits>
#include <random>

using namespace afterglow;

namespace {

constexpr int side = ImagePatch::side;

/// A third of the pixels are white, so that some places between pixels are, too.
GreyImage noise_image(unsigned seed) {
    GreyImage image(23, 19);
    std::mt19937 random(seed);
    std::uniform_int_distribution<int> any(0, 380 * grey_steps);
    std::ranges::generate(image.pixels(), [&] {
        return static_cast<Grey>(std::min(any(random), static_cast<int>(white) * grey_steps));
    });
    return image;
}
/// A smooth picture, `du` and `dv` pixels farther right and down.
GreyImage waves(float du, float dv) {
    GreyImage image(40, 30);
    for (int v = 0; v < image.height(); ++v)
        for (int u = 0; u < image.width(); ++u) {
            const float x = static_cast<float>(u) - du, y = static_cast<float>(v) - dv;
            const float grey = 128 + 50 * std::sin(0.5f * x) + 40 * std::cos(0.4f * y + 0.2f * x);
            image(u, v) = static_cast<Grey>(grey_steps * grey);
        }
    return image;
}
float grey_at(const GreyImage &image, int u, int v) {
    return grey_step * static_cast<float>(image(u, v));
}
float between(const GreyImage &image, float u, float v) {
    const int x = static_cast<int>(u), y = static_cast<int>(v);
    const float r = u - static_cast<float>(x), d = v - static_cast<float>(y);
    return (1 - d) * ((1 - r) * grey_at(image, x, y) + r * grey_at(image, x + 1, y)) +
           d * ((1 - r) * grey_at(image, x, y + 1) + r * grey_at(image, x + 1, y + 1));
}
/// How much brighter than `now` a pixel is expected that had the grey value `then`.
float excess(float then, const Brightness &brightness, float now) {
    const float more = std::min(brightness.gain * then + brightness.offset, white) - now;
    return then > nearly_white ? std::max(more, 0.0f) : more;
}

} // namespace

TEST_CASE("an image patch is compared with another image after both means are taken off",
          "[core]") {
    AFTERGLOW_ON_EACH_INSTRUCTION_SET();
    const GreyImage now = noise_image(1), then = noise_image(2);
    const int u = GENERATE(1, 5, 14), v = GENERATE(1, 10);
    const Eigen::Vector2f place = {GENERATE(0.0f, 3.25f, 14.9f), GENERATE(0.0f, 7.5f)};
    // Some of both images is white.
    const Brightness brightness{GENERATE(0.8f, 1.3f), GENERATE(-4.0f, 6.0f)};
    REQUIRE(shows_patch(then, place));
    const PatchFit fit = fit_patch(patch_at(now, u, v), then, place, brightness);

    // The same in double precision, by the definitions.
    double mean = 0, mean_u = 0, mean_v = 0;
    const auto each = [&](const auto &visit) {
        for (int j = 0; j < side; ++j)
            for (int i = 0; i < side; ++i) {
                const int x = u + i, y = v + j;
                const float seen = between(then, place.x() + static_cast<float>(i),
                                           place.y() + static_cast<float>(j));
                visit(excess(seen, brightness, grey_at(now, x, y)),
                      0.5 * (grey_at(now, x + 1, y) - grey_at(now, x - 1, y)),
                      0.5 * (grey_at(now, x, y + 1) - grey_at(now, x, y - 1)));
            }
    };
    each([&](double e, double by_u, double by_v) {
        mean += e / (side * side);
        mean_u += by_u / (side * side);
        mean_v += by_v / (side * side);
    });
    double square = 0;
    Eigen::Matrix2d H = Eigen::Matrix2d::Zero();
    Eigen::Vector2d b = Eigen::Vector2d::Zero();
    each([&](double e, double by_u, double by_v) {
        const Eigen::Vector2d g = {by_u - mean_u, by_v - mean_v};
        square += (e - mean) * (e - mean) / (side * side);
        H += g * g.transpose();
        b += g * e;
    });
    const Eigen::Vector2d step = -H.inverse() * b;
    CHECK(fit.mean_square == Approx(square).epsilon(1e-3));
    CHECK((fit.step.cast<double>() - step).norm() < 1e-3);
    CHECK(mean_excess(now, u, v, then, place, brightness) == Approx(mean).margin(1e-3));
}

TEST_CASE("an image patch that has become brighter than a camera shows differs in nothing",
          "[core]") {
    AFTERGLOW_ON_EACH_INSTRUCTION_SET();
    const auto seen_at = [](float gain) {
        GreyImage image = waves(0, 0);
        for (Grey &grey : image.pixels())
            grey = static_cast<Grey>(std::min(gain * static_cast<float>(grey), white * grey_steps));
        return image;
    };
    const float then_gain = GENERATE(1.0f, 1.6f, 2.5f), now_gain = GENERATE(1.0f, 1.6f, 2.5f);
    const Brightness brightness{now_gain / then_gain, 0};
    const GreyImage then = seen_at(then_gain), now = seen_at(now_gain);
    CHECK(fit_patch(patch_at(now, 15, 10), then, {15, 10}, brightness).mean_square < 1);
    CHECK(std::abs(mean_excess(now, 15, 10, then, {15, 10}, brightness)) < 1);
    Image<float> least(now.width(), now.height(), std::numeric_limits<float>::max());
    Image<std::int32_t> owners(now.width(), now.height(), -1);
    claim_pixels(now, 15, 10, then, {15, 10}, brightness, 7, least, owners);
    for (int v = 10; v < 10 + side; ++v)
        for (int u = 15; u < 15 + side; ++u) {
            CHECK(least(u, v) < 1);
            CHECK(owners(u, v) == 7);
        }
}

TEST_CASE("Gauss-Newton steps find a displaced image patch between pixels", "[core]") {
    AFTERGLOW_ON_EACH_INSTRUCTION_SET();
    const GreyImage then = waves(0, 0), now = waves(1.3f, -0.8f);
    const ImagePatch patch = patch_at(now, 15, 10);
    REQUIRE(patch.is_distinct());
    Eigen::Vector2f place = {15, 10};
    for (int i = 0; i < 6; ++i)
        place += fit_patch(patch, then, place, {}).step;
    CHECK(place.x() == Approx(13.7).margin(0.05));
    CHECK(place.y() == Approx(10.8).margin(0.05));
    CHECK(fit_patch(patch, then, place, {}).mean_square < 1);
}

TEST_CASE("an image patch without gradients in two directions is not distinct", "[core]") {
    GreyImage image(20, 20, 100 * grey_steps);
    CHECK_FALSE(patch_at(image, 5, 5).is_distinct());
    for (int v = 0; v < image.height(); ++v)
        for (int u = 0; u < image.width(); ++u)
            image(u, v) = static_cast<Grey>(u % 5 * 40 * grey_steps);
    CHECK_FALSE(patch_at(image, 5, 5).is_distinct());
}

TEST_CASE("an image shows a patch if it has all pixels that bilinear sampling reads", "[core]") {
    const GreyImage image(20, 16);
    CHECK(shows_patch(image, {0, 0}));
    CHECK(shows_patch(image, {11.9f, 7.9f}));
    CHECK_FALSE(shows_patch(image, {12, 0}));
    CHECK_FALSE(shows_patch(image, {0, 8}));
    CHECK_FALSE(shows_patch(image, {-0.1f, 0}));
    CHECK_FALSE(shows_patch(image, {0, -0.1f}));
    constexpr float nan = std::numeric_limits<float>::quiet_NaN();
    CHECK_FALSE(shows_patch(image, {nan, 0}));
}

TEST_CASE("each pixel is owned by the image patch that differs least around it", "[core]") {
    AFTERGLOW_ON_EACH_INSTRUCTION_SET();
    const GreyImage now = noise_image(3), then = noise_image(4);
    Image<float> least(now.width(), now.height(), std::numeric_limits<float>::max());
    Image<std::int32_t> owners(now.width(), now.height(), -1);
    Image<float> expected_least = least;
    Image<std::int32_t> expected = owners;
    const struct Square {
        int u, v;
        Eigen::Vector2f place;
    } squares[] = {{1, 1, {2.5f, 3.5f}}, {5, 1, {0, 0}}, {5, 5, {13.25f, 4}}, {1, 5, {7, 9.75f}}};
    std::int32_t owner = 0;
    for (const Square &square : squares) {
        const int u = square.u, v = square.v;
        const Eigen::Vector2f &place = square.place;
        const Brightness brightness{1.1f, -5};
        claim_pixels(now, u, v, then, place, brightness, owner, least, owners);
        const auto difference = [&](int i, int j) {
            i = std::clamp(i, 0, side - 1);
            j = std::clamp(j, 0, side - 1);
            const float seen =
                between(then, place.x() + static_cast<float>(i), place.y() + static_cast<float>(j));
            return std::abs(excess(seen, brightness, grey_at(now, u + i, v + j)));
        };
        for (int j = 0; j < side; ++j)
            for (int i = 0; i < side; ++i) {
                float sum = 0;
                for (int y = -1; y <= 1; ++y)
                    for (int x = -1; x <= 1; ++x)
                        sum += difference(i + x, j + y);
                if (sum / 9 < expected_least(u + i, v + j)) {
                    expected_least(u + i, v + j) = sum / 9;
                    expected(u + i, v + j) = owner;
                }
            }
        ++owner;
    }
    CHECK(owners == expected);
    for (std::size_t i = 0; i < least.pixels().size(); ++i)
        CHECK(least.pixels()[i] == Approx(expected_least.pixels()[i]).epsilon(1e-4));
}
