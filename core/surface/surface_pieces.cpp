// SPDX-License-Identifier: Apache-2.0
// Compiled once for each instruction set; the best of them is chosen when first called.
#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "core/surface/surface_pieces.cpp"
#include "core/surface/surface_pieces.hpp"

#include "core/surface/surface_point.hpp"

#include <algorithm>
#include <bit>
#include <cstdlib>
#include <hwy/cache_control.h>
#include <hwy/foreach_target.h>
#include <hwy/highway.h>

HWY_BEFORE_NAMESPACE();
namespace afterglow::HWY_NAMESPACE {
namespace {

namespace hn = hwy::HWY_NAMESPACE;

/// The whole pieces of a row of pieces. Depths are not negative, so their bits are in their order;
/// less one, no depth is beyond all, and no edge distance, too.
void find_row(ImageView<const float> z, int first_row, float *HWY_RESTRICT nearest,
              float *HWY_RESTRICT farthest, std::uint8_t *HWY_RESTRICT edges) {
    constexpr int px = SurfacePieces::piece_px;
    const hn::CappedTag<std::uint32_t, px> d;
    const hn::RebindToFloat<decltype(d)> df;
    const int end_row = std::min(first_row + px, z.height());
    const int next_end = std::min(end_row + px, z.height());
    const auto one = hn::Set(d, 1), edge_bits = hn::Set(d, edge_distance_bits);
    for (int x = 0; x < z.width() / px; ++x) {
        if (x % 2 == 0) { // a cache line of the next row of pieces, far away in memory
            const float *line = z.row(end_row) + x * px;
            for (int v = end_row; v < next_end; ++v, line += z.stride())
                hwy::Prefetch(line);
        }
        auto near = hn::Set(d, ~std::uint32_t{0}), edge = near, least = near, far = hn::Zero(d);
        for (int v = first_row; v < end_row; ++v)
            for (int u = x * px; u < (x + 1) * px; u += static_cast<int>(hn::Lanes(d))) {
                const auto bits = hn::BitCast(d, hn::LoadU(df, z.row(v) + u));
                least = hn::Min(least, bits);
                near = hn::Min(near, hn::Sub(bits, one));
                edge = hn::Min(edge, hn::Sub(hn::And(bits, edge_bits), one));
                far = hn::Max(far, bits);
            }
        const auto of_all = [&](auto value) HWY_ATTR { return hn::GetLane(value); };
        nearest[x] = std::bit_cast<float>(of_all(hn::MinOfLanes(d, near)) + 1);
        farthest[x] = std::bit_cast<float>(of_all(hn::MaxOfLanes(d, far)));
        const bool holes = of_all(hn::MinOfLanes(d, least)) == 0;
        edges[x] = static_cast<std::uint8_t>((of_all(hn::MinOfLanes(d, edge)) + 1) |
                                             (holes ? SurfacePieces::has_holes : 0));
    }
}

} // namespace
} // namespace afterglow::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace afterglow {
namespace {

HWY_EXPORT(find_row);

constexpr int piece_count(int pixels) {
    return (pixels + SurfacePieces::piece_px - 1) / SurfacePieces::piece_px;
}

} // namespace

SurfacePieces::SurfacePieces(int width, int height)
    : nearest_(piece_count(width), piece_count(height)),
      farthest_(nearest_.width(), nearest_.height()), edges_(nearest_.width(), nearest_.height()),
      parts_(nearest_.width(), nearest_.height()) {}

void SurfacePieces::find(ImageView<const float> z) {
    for (int y = 0; y < nearest_.height(); ++y) {
        const int first_row = y * piece_px, end_row = std::min(first_row + piece_px, z.height());
        float *const nearest = nearest_.row(y), *const farthest = farthest_.row(y);
        std::uint8_t *const edges = edges_.row(y);
        HWY_DYNAMIC_DISPATCH(find_row)(z, first_row, nearest, farthest, edges);
        for (int x = z.width() / piece_px; x < nearest_.width(); ++x) {
            float near = 0, far = 0;
            std::uint8_t edge = 0, holes = 0;
            for (int v = first_row; v < end_row; ++v)
                for (int u = x * piece_px; u < std::min((x + 1) * piece_px, z.width()); ++u) {
                    const float depth = z(u, v);
                    if (depth == 0.0f) {
                        holes = has_holes;
                        continue;
                    }
                    const std::uint8_t distance = edge_distance_of(depth);
                    edge = edge == 0 ? distance : std::min(edge, distance);
                    near = near == 0.0f ? depth : std::min(near, depth);
                    far = std::max(far, depth);
                }
            nearest[x] = near;
            farthest[x] = far;
            edges[x] = edge | holes;
        }
    }
    mark_beside_holes();
    find_parts();
}

void SurfacePieces::find_parts() {
    for (std::size_t i = 0; i < parts_.pixels().size(); ++i) {
        const std::uint8_t edges = edges_.pixels()[i];
        parts_.pixels()[i] = SurfacePart(nearest_.pixels()[i], farthest_.pixels()[i],
                                         edges & edge_distance_bits, (edges & has_holes) != 0);
    }
}

void SurfacePieces::mark_beside_holes() {
    const ImageView<const float> depth = farthest_;
    for (int y = 0; y < depth.height(); ++y)
        for (int x = 0; x < depth.width(); ++x) {
            if (depth(x, y) != 0.0f)
                continue;
            edges_(std::max(x - 1, 0), y) |= has_holes;
            edges_(std::min(x + 1, depth.width() - 1), y) |= has_holes;
            edges_(x, std::max(y - 1, 0)) |= has_holes;
            edges_(x, std::min(y + 1, depth.height() - 1)) |= has_holes;
        }
}

float SurfacePieces::nearest_around(int u, int v) const {
    constexpr int reach = 3;
    const int column = u / piece_px, row = v / piece_px;
    for (int ring = 0; ring <= reach; ++ring)
        for (int y = row - ring; y <= row + ring; ++y) {
            const int step = std::abs(y - row) == ring ? 1 : std::max(2 * ring, 1);
            for (int x = column - ring; x <= column + ring; x += step)
                if (nearest().contains(x, y) && nearest_(x, y) != 0.0f)
                    return nearest_(x, y);
        }
    return 0;
}

} // namespace afterglow
#endif
