// SPDX-License-Identifier: Apache-2.0
#include "drivers/simulated/synthetic/texture.hpp"

#include "drivers/simulated/synthetic/random.hpp"

#include <algorithm>
#include <cassert>
#include <cmath>
#include <utility>

namespace afterglow {
namespace {

/// Value noise, -1 to 1, that repeats with the texture: random numbers on a lattice of `cells_x` by
/// `cells_y`, smoothly between them.
double value_noise(double x, double y, int cells_x, int cells_y, std::uint64_t seed) {
    const auto at = [&](int i, int j) {
        const auto cell =
            static_cast<std::uint64_t>(j % cells_y) * static_cast<std::uint64_t>(cells_x) +
            static_cast<std::uint64_t>(i % cells_x);
        return static_cast<double>(mix(mix(seed) + cell) >> 11) * 0x1p-52 - 1;
    };
    const auto smooth = [](double f) { return f * f * (3 - 2 * f); };
    const double u = x / Texture::size * cells_x;
    const double v = y / Texture::size * cells_y;
    const int i = static_cast<int>(u);
    const int j = static_cast<int>(v);
    const double fu = smooth(u - i);
    const double fv = smooth(v - j);
    return std::lerp(std::lerp(at(i, j), at(i + 1, j), fu),
                     std::lerp(at(i, j + 1), at(i + 1, j + 1), fu), fv);
}

/// Noise of all scales from `cells` to `cells` * 2^(octaves - 1), each half as strong as the last.
double fractal_noise(double x, double y, int cells, int octaves, std::uint64_t seed) {
    double sum = 0;
    for (int octave = 0; octave < octaves; ++octave)
        sum += std::ldexp(value_noise(x, y, cells << octave, cells << octave,
                                      seed + static_cast<std::uint64_t>(octave)),
                          -octave);
    return sum / 2;
}

double plaster(int x, int y, std::uint64_t seed) {
    const double stain = value_noise(x, y, 24, 24, seed + 50);
    return 165 + 22 * fractal_noise(x, y, 8, 6, seed) - (stain > 0.55 ? 90 * (stain - 0.55) : 0);
}

double wood(int x, int y, std::uint64_t seed) {
    constexpr int plank = Texture::size / 8;
    const int row = y / plank;
    const auto of_row = mix(seed + static_cast<std::uint64_t>(row));
    const int joint = (x + static_cast<int>(of_row % Texture::size)) % (Texture::size / 2);
    const double tone = static_cast<double>(of_row >> 32 & 63) - 32;
    const double grain =
        value_noise(x, y, 8, 128, seed + 70) + value_noise(x, y, 64, 256, seed + 71);
    return y % plank < 2 || joint < 2 ? 45 : 120 + tone + 16 * grain;
}

double tiles(int x, int y, std::uint64_t seed) {
    constexpr int tile = Texture::size / 16;
    const int cell = y / tile * 16 + x / tile;
    const double tone = static_cast<double>(mix(seed + static_cast<std::uint64_t>(cell)) % 80);
    return x % tile < 2 || y % tile < 2 ? 60 : 110 + tone + 14 * fractal_noise(x, y, 16, 4, seed);
}

/// Rectangles and discs of many sizes over each other.
std::vector<std::uint8_t> print(std::uint64_t seed) {
    constexpr int size = Texture::size;
    std::vector<std::uint8_t> texels(std::size_t{size} * size, 200);
    const auto wrapped = [](int at) { return static_cast<std::size_t>((at + size) % size); };
    Random random(seed, 2);
    for (int shape = 0; shape < 500; ++shape) {
        const int half_width = 2 + random.below(shape < 100 ? 50 : 12);
        const int half_height = 2 + random.below(shape < 100 ? 50 : 12);
        const int x0 = random.below(size);
        const int y0 = random.below(size);
        const auto tone = static_cast<std::uint8_t>(20 + random.below(220));
        const bool round = random.below(3) == 0;
        for (int y = -half_height; y <= half_height; ++y) {
            for (int x = -half_width; x <= half_width; ++x) {
                const double rx = static_cast<double>(x) / half_width;
                const double ry = static_cast<double>(y) / half_height;
                if (!round || rx * rx + ry * ry <= 1)
                    texels[wrapped(y0 + y) * size + wrapped(x0 + x)] = tone;
            }
        }
    }
    return texels;
}

} // namespace

Texture::Texture(std::vector<std::uint8_t> texels) : texels_(std::move(texels)) {
    assert(texels_.size() == std::size_t{size} * size);
    static_assert(size >> (levels - 1) == 1);
    texels_.resize(static_cast<std::size_t>(begin_of(levels - 1)) + 1);
    for (int level = 1; level < levels; ++level) {
        const int side = size >> level;
        const std::uint8_t *from = texels_.data() + begin_of(level - 1);
        std::uint8_t *to = texels_.data() + begin_of(level);
        for (int y = 0; y < side; ++y) {
            for (int x = 0; x < side; ++x) {
                const std::uint8_t *block = from + 2 * y * (2 * side) + 2 * x;
                const int sum = block[0] + block[1] + block[2 * side] + block[2 * side + 1];
                to[y * side + x] = static_cast<std::uint8_t>((sum + 2) / 4);
            }
        }
    }
}

Texture make_texture(Pattern pattern, std::uint64_t seed) {
    if (pattern == Pattern::print)
        return Texture(print(seed));
    const auto tone = pattern == Pattern::plaster ? plaster
                      : pattern == Pattern::wood  ? wood
                                                  : tiles;
    std::vector<std::uint8_t> texels;
    texels.reserve(std::size_t{Texture::size} * Texture::size);
    for (int y = 0; y < Texture::size; ++y) {
        for (int x = 0; x < Texture::size; ++x)
            texels.push_back(static_cast<std::uint8_t>(std::clamp(tone(x, y, seed), 0.0, 255.0)));
    }
    return Texture(std::move(texels));
}

} // namespace afterglow
