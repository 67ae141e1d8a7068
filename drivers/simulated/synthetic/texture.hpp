// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <cstdint>
#include <vector>

namespace afterglow {

/// A square pattern that repeats, with its mip levels: each half the size of the one before and
/// its average, so that a lookup at the level of the pixel's footprint does not alias.
class Texture {
public:
    /// Side of level 0 in texels, and how many metres of a surface they cover.
    static constexpr int size = 512;
    static constexpr int levels = 10;
    static constexpr double metres = 2.56;
    static constexpr float texels_per_metre = static_cast<float>(size / metres);

    /// `texels`: size x size luma values, row by row.
    explicit Texture(std::vector<std::uint8_t> texels);

    /// Luma, 8 bits of fraction, at (s, t) metres: bilinear in two levels, and between them.
    /// `level` is the base-2 logarithm of the footprint in texels of level 0; any number will do.
    int sample(float s, float t, float level) const {
        const float x = s * texels_per_metre;
        const float y = t * texels_per_metre;
        const float clamped = std::clamp(level, 0.0F, static_cast<float>(levels) - 1.01F);
        const int fine = static_cast<int>(clamped);
        const int share = static_cast<int>((clamped - static_cast<float>(fine)) * 256);
        const int value = bilinear(x, y, fine);
        if (share == 0)
            return value;
        return (value * (256 - share) + bilinear(x, y, fine + 1) * share) >> 8;
    }

private:
    /// Where a level begins: after the finer ones, each a quarter of the one before.
    static constexpr int begin_of(int level) {
        return (size * size - (size >> level) * (size >> level)) / 3 * 4;
    }

    /// (x, y) in texels of level 0, from -size on.
    int bilinear(float x, float y, int level) const {
        // Fixed point with 8 bits of fraction. One period more keeps it from being negative; half
        // a texel less takes it from the texels' corners to their centres.
        const int side = size >> level;
        const float scale = static_cast<float>(side) * (256.0F / size);
        const int fixed_x = static_cast<int>((x + size) * scale) - 128;
        const int fixed_y = static_cast<int>((y + size) * scale) - 128;
        const int fx = fixed_x & 255;
        const int fy = fixed_y & 255;
        const int mask = side - 1;
        const int x0 = (fixed_x >> 8) & mask;
        const int x1 = (x0 + 1) & mask;
        const std::uint8_t *row0 =
            texels_.data() + begin_of(level) + ((fixed_y >> 8) & mask) * side;
        const std::uint8_t *row1 =
            texels_.data() + begin_of(level) + (((fixed_y >> 8) + 1) & mask) * side;
        const int above = row0[x0] * (256 - fx) + row0[x1] * fx;
        const int below = row1[x0] * (256 - fx) + row1[x1] * fx;
        return (above * (256 - fy) + below * fy) >> 8;
    }

    std::vector<std::uint8_t> texels_; // all levels, finest first
};

/// Patterns by kind and seed. `plaster` is faint, the others are rich in corners.
enum class Pattern { plaster, wood, tiles, print };
Texture make_texture(Pattern pattern, std::uint64_t seed);

} // namespace afterglow
