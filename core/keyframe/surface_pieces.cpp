// SPDX-License-Identifier: Apache-2.0
// Compiled once for each instruction set; the best of them is chosen when first called.
#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "core/keyframe/surface_pieces.cpp"
#include "core/keyframe/surface_pieces.hpp"

#include "core/keyframe/surface_point.hpp"

#include <algorithm>
#include <hwy/foreach_target.h>
#include <hwy/highway.h>

HWY_BEFORE_NAMESPACE();
namespace afterglow::HWY_NAMESPACE {
namespace {

namespace hn = hwy::HWY_NAMESPACE;

/// As many whole pieces of a row as fill vectors, from the left. Depths are not negative, so their
/// bits are in their order; less one, no depth is beyond all, and no edge distance, too. Returns
/// how many pieces it has found.
int find_row(ImageView<const float> z, int first_row, float *HWY_RESTRICT nearest,
             float *HWY_RESTRICT farthest, std::uint8_t *HWY_RESTRICT edges) {
    constexpr int px = SurfacePieces::piece_px;
    static_assert(px == 4, "so many columns are loaded at once");
    const hn::ScalableTag<std::uint32_t> d;
    const hn::RebindToSigned<decltype(d)> di;
    const hn::Rebind<float, decltype(d)> df;
    const hn::Rebind<std::uint8_t, decltype(d)> d8;
    const int lanes = static_cast<int>(hn::Lanes(d)), whole = z.width() / px;
    const int end_row = std::min(first_row + px, z.height());
    const auto one = hn::Set(d, 1), edge_bits = hn::Set(d, edge_distance_bits);
    const auto has_holes = hn::Set(d, SurfacePieces::has_holes);
    int x = 0;
    for (; x + lanes <= whole; x += lanes) {
        auto least = hn::Set(d, ~std::uint32_t{0}), near = least, edge = least, far = hn::Zero(d);
        for (int v = first_row; v < end_row; ++v) {
            hn::Vec<decltype(df)> depths[px];
            hn::LoadInterleaved4(df, z.row(v) + x * px, depths[0], depths[1], depths[2], depths[3]);
            for (const auto &column : depths) {
                const auto bits = hn::BitCast(d, column);
                least = hn::Min(least, bits);
                near = hn::Min(near, hn::Sub(bits, one));
                edge = hn::Min(edge, hn::Sub(hn::And(bits, edge_bits), one));
                far = hn::Max(far, bits);
            }
        }
        hn::StoreU(hn::BitCast(df, hn::Add(near, one)), df, nearest + x);
        hn::StoreU(hn::BitCast(df, far), df, farthest + x);
        const auto holes = hn::Eq(least, hn::Zero(d));
        const auto found = hn::Or(hn::Add(edge, one), hn::IfThenElseZero(holes, has_holes));
        hn::StoreU(hn::DemoteTo(d8, hn::BitCast(di, found)), d8, edges + x);
    }
    return x;
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
      farthest_(nearest_.width(), nearest_.height()),
      edges_(nearest_.width(), nearest_.height()) {}

void SurfacePieces::find(ImageView<const float> z) {
    for (int y = 0; y < nearest_.height(); ++y) {
        const int first_row = y * piece_px, end_row = std::min(first_row + piece_px, z.height());
        float *const nearest = nearest_.row(y), *const farthest = farthest_.row(y);
        std::uint8_t *const edges = edges_.row(y);
        int x = HWY_DYNAMIC_DISPATCH(find_row)(z, first_row, nearest, farthest, edges);
        for (; x < nearest_.width(); ++x) {
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
}

} // namespace afterglow
#endif
