// SPDX-License-Identifier: Apache-2.0
#include "drivers/simulated/synthetic/noise.hpp"

#include "drivers/simulated/synthetic/random.hpp"

#include <algorithm>
#include <array>
#include <cassert>
#include <cmath>
#include <cstddef>

namespace afterglow {
namespace {

constexpr std::size_t draws = std::size_t{1} << 16;
constexpr float image_sigma = 1.5F;

enum Stream : std::uint64_t { table, depth_rows, flying_rows, image_rows, amplitude_rows };

/// A number for a row of a frame.
std::uint64_t of_row(std::uint64_t seed, Stream stream, std::uint64_t frame, int v) {
    return mix(mix(mix(seed + stream) + frame) + static_cast<std::uint64_t>(v));
}

/// The depth, of a pixel's four neighbours, that differs most from its own. Outside the image and
/// where there is nothing counts as its own.
float most_different(ImageView<const float> z, int u, int v) {
    const float here = z.row(v)[u];
    float most = here;
    const auto consider = [&](float there) {
        if (there > 0 && std::abs(there - here) > std::abs(most - here))
            most = there;
    };
    consider(z.row(v)[std::max(u - 1, 0)]);
    consider(z.row(v)[std::min(u + 1, z.width() - 1)]);
    consider(z.row(std::max(v - 1, 0))[u]);
    consider(z.row(std::min(v + 1, z.height() - 1))[u]);
    return most;
}

} // namespace

Noise::Noise(std::uint64_t seed, const TofNoise &tof) : seed_(seed), tof_(tof) {
    Random random(seed, 3);
    normal_.reserve(draws);
    for (std::size_t i = 0; i < draws; ++i)
        normal_.push_back(static_cast<float>(random.normal()));
}

void Noise::measure(std::uint64_t frame, ImageView<const float> z, LumaView luma,
                    ImageView<std::uint16_t> depth) const {
    assert(z.same_size(depth) && luma.same_size(depth));
    const auto near = static_cast<float>(tof_.nearest);
    const auto far = static_cast<float>(tof_.furthest);
    const auto sigma = static_cast<float>(tof_.sigma_at_0);
    const auto sigma_per_square = static_cast<float>(tof_.sigma_per_square);
    const auto bias = static_cast<float>(tof_.range_bias);
    const auto edge = static_cast<float>(tof_.edge);
    const auto saturation = static_cast<float>(tof_.saturation) * 255;
    for (int v = 0; v < depth.height(); ++v) {
        const std::size_t first = of_row(seed_, depth_rows, frame, v);
        Random random(of_row(seed_, flying_rows, frame, v));
        for (int u = 0; u < depth.width(); ++u) {
            float here = z.row(v)[u];
            depth.row(v)[u] = 0;
            if (here <= 0)
                continue;
            const float other = most_different(z, u, v);
            if (std::abs(other - here) > edge * here && random.uniform() < tof_.flying)
                here += static_cast<float>(random.uniform()) * (other - here);
            if (here < near || here > far ||
                (saturation > 0 && luma.row(v)[u] > saturation * here * here))
                continue;
            const float normal = normal_[(first + static_cast<std::size_t>(u)) % draws];
            const float measured = here + bias + normal * (sigma + sigma_per_square * here * here);
            depth.row(v)[u] =
                static_cast<std::uint16_t>(std::clamp(measured * 1000 + 0.5F, 0.0F, 65535.0F));
        }
    }
}

void Noise::add_to(std::uint64_t frame, ImageView<std::uint8_t> luma) const {
    for (int v = 0; v < luma.height(); ++v) {
        const std::size_t first = of_row(seed_, image_rows, frame, v);
        for (int u = 0; u < luma.width(); ++u) {
            const float normal = normal_[(first + static_cast<std::size_t>(u)) % draws];
            const float sum = static_cast<float>(luma.row(v)[u]) + image_sigma * normal + 0.5F;
            luma.row(v)[u] = static_cast<std::uint8_t>(std::clamp(sum, 0.0F, 255.0F));
        }
    }
}

void Noise::add_shot_noise_to(std::uint64_t frame, ImageView<std::uint16_t> amplitude) const {
    for (int v = 0; v < amplitude.height(); ++v) {
        const std::size_t first = of_row(seed_, amplitude_rows, frame, v);
        for (int u = 0; u < amplitude.width(); ++u) {
            const auto light = static_cast<float>(amplitude.row(v)[u]);
            const float normal = normal_[(first + static_cast<std::size_t>(u)) % draws];
            const float sum = light + std::sqrt(light) * normal + 0.5F;
            amplitude.row(v)[u] = static_cast<std::uint16_t>(std::clamp(sum, 0.0F, 65535.0F));
        }
    }
}

} // namespace afterglow
