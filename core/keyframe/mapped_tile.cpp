// SPDX-License-Identifier: Apache-2.0
// Compiled once for each instruction set; the best of them is chosen when first called.
#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "core/keyframe/mapped_tile.cpp"
#include "core/keyframe/mapped_tile.hpp"

#include "core/keyframe/parallax_tile.hpp"

#include <algorithm>
#include <hwy/foreach_target.h>
#include <hwy/highway.h>

// clang-format off: after Highway, once for each instruction set
#include "core/base/lanes-inl.hpp"
#include "core/keyframe/surface_point-inl.hpp"
#include "core/keyframe/tile_pixels-inl.hpp"
// clang-format on

HWY_BEFORE_NAMESPACE();
namespace afterglow::HWY_NAMESPACE {
namespace {

/// How much the depth of a tile's surface changes along its columns and rows, metres per pixel.
struct TileSlope {
    float by_u = 0, by_v = 0;
};
/// From the depths at the corners, along both diagonals; at most `steepest`.
TileSlope slope_between(const MappedTile &tile) {
    const MappedCorner &a = tile.corners[0], &b = tile.corners[1];
    const MappedCorner &c = tile.corners[2], &e = tile.corners[3];
    const float u1 = e.u - a.u, v1 = e.v - a.v, z1 = e.z - a.z;
    const float u2 = c.u - b.u, v2 = c.v - b.v, z2 = c.z - b.z;
    const float area = u1 * v2 - u2 * v1, most = steepest * a.z;
    return {std::clamp((z1 * v2 - z2 * v1) / area, -most, most),
            std::clamp((u1 * z2 - u2 * z1) / area, -most, most)};
}

/// Looks up the nearest points, and moves their depths along the slope between the corners.
class NearestPoints {
public:
    NearestPoints(const MappedTile &tile, ImageView<const float> z, int least_edge_distance)
        : slope_(slope_between(tile)), places_(tile), z_(z),
          least_edge_distance_(least_edge_distance) {}

    const TilePlaces &places() const { return places_; }
    template <class D, class Pixels>
    HWY_INLINE void operator()(D d, Pixels &pixels) const {
        const hn::RebindToSigned<D> di;
        const hn::RebindToUnsigned<D> du;
        const hn::Rebind<std::uint16_t, D> d16;
        const auto half = hn::Set(d, 0.5f);
        const auto inside = [&](auto place, int end) HWY_ATTR {
            return hn::RebindMask(
                di, hn::Lt(hn::BitCast(du, place), hn::Set(du, static_cast<std::uint32_t>(end))));
        };
        for (int i = 0; i < Pixels::vectors; ++i) {
            const auto u = pixels.at(&TilePlaces::u, i), v = pixels.at(&TilePlaces::v, i);
            const auto x = hn::ConvertTo(di, hn::Add(u, half));
            const auto y = hn::ConvertTo(di, hn::Add(v, half));
            const auto in_picture = hn::And(inside(x, z_.width()), inside(y, z_.height()));
            const auto place = hn::Add(hn::Mul(y, hn::Set(di, z_.stride())), x);
            const auto point = gather(d, z_.data(), hn::IfThenElseZero(in_picture, place));
            const auto moved_by =
                hn::Add(hn::Mul(hn::Set(d, slope_.by_u), hn::Sub(u, hn::ConvertTo(d, x))),
                        hn::Mul(hn::Set(d, slope_.by_v), hn::Sub(v, hn::ConvertTo(d, y))));
            const auto reading =
                hn::Add(hn::Mul(hn::Add(point, moved_by), pixels.at(&TilePlaces::scale, i)),
                        pixels.at(&TilePlaces::shift, i));
            const auto edge = edge_of(d, point);
            const auto there =
                hn::And(in_picture, hn::Gt(edge, hn::Set(di, least_edge_distance_ - 1)));
            const auto whole = hn::IfThenElseZero(there, hn::ConvertTo(di, hn::Add(reading, half)));
            pixels.put(i, hn::DemoteTo(d16, whole), hn::IfThenElseZero(there, edge), point);
        }
    }

private:
    TileSlope slope_;
    TilePlaces places_;
    ImageView<const float> z_;
    int least_edge_distance_;
};

int draw(const MappedTile &tile, ImageView<const float> z, int least_edge_distance,
         ImageView<std::uint16_t> millimetres, ImageView<std::uint8_t> edge_distance) {
    return draw_tile<false>(tile, NearestPoints(tile, z, least_edge_distance),
                            {millimetres, edge_distance});
}

} // namespace
} // namespace afterglow::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace afterglow {
namespace {

HWY_EXPORT(draw);

} // namespace

int draw_mapped(const MappedTile &tile, ImageView<const float> z, int least_edge_distance,
                ImageView<std::uint16_t> millimetres, ImageView<std::uint8_t> edge_distance) {
    if (!tile.one_surface)
        return draw_by_parallax(tile, z, least_edge_distance, millimetres, edge_distance);
    return HWY_DYNAMIC_DISPATCH(draw)(tile, z, least_edge_distance, millimetres, edge_distance);
}

} // namespace afterglow
#endif
