// SPDX-License-Identifier: Apache-2.0
//
// Where pixels of a mapped tile are on the surface, in vectors. Included once for each instruction
// set, like lanes-inl.hpp.
#if defined(AFTERGLOW_CORE_WARP_TILE_PLACES_INL_HPP) == defined(HWY_TARGET_TOGGLE)
#ifdef AFTERGLOW_CORE_WARP_TILE_PLACES_INL_HPP
#undef AFTERGLOW_CORE_WARP_TILE_PLACES_INL_HPP
#else
#define AFTERGLOW_CORE_WARP_TILE_PLACES_INL_HPP
#endif

#include "core/base/lanes-inl.hpp"
#include "core/warp/mapped_tile.hpp"

#include <hwy/highway.h>

HWY_BEFORE_NAMESPACE();
namespace afterglow::HWY_NAMESPACE {
namespace {

namespace hn = hwy::HWY_NAMESPACE;

inline constexpr int block_px = mapped_block_px, blocks_across = mapped_tile_px / block_px;
/// A point that was searched for is not seen at its place if its own parallax puts it farther from
/// there, pixels (sum of columns and rows).
inline constexpr float most_missed_px = 3.0f;

/// Bilinear between a tile's corners, at pixel (x, y) of the tile: at + x across + y (down + x
/// twist).
struct BetweenCorners {
    float at, across, down, twist;

    BetweenCorners(const MappedTile &tile, float MappedCorner::*of) {
        constexpr float part = 1.0f / mapped_tile_px;
        const float a = tile.corners[0].*of, b = tile.corners[1].*of;
        const float c = tile.corners[2].*of, e = tile.corners[3].*of;
        at = a;
        across = part * (b - a);
        down = part * (c - a);
        twist = part * (part * (e - c) - across);
    }
};
/// Where pixels of a tile are on the surface, and how readings follow from depths there.
struct TilePlaces {
    BetweenCorners u, v, scale, shift;

    explicit TilePlaces(const MappedTile &tile)
        : u(tile, &MappedCorner::u), v(tile, &MappedCorner::v), scale(tile, &MappedCorner::scale),
          shift(tile, &MappedCorner::shift) {}
};

/// By how much points are displaced that have not the depth of a tile's corners.
template <class V>
struct Parallax {
    V inverse_depth, u, v;
};
template <class D>
HWY_API Parallax<hn::Vec<D>> parallax_of(D d, const MappedTile &tile) {
    return {hn::Set(d, tile.inverse_depth), hn::Set(d, tile.parallax_u),
            hn::Set(d, tile.parallax_v)};
}

/// The inverse depths, 1/m, of the nearest points to some places; `missing` where there is none.
template <class D, class V>
HWY_API V inverse_depth_near(D d, ImageView<const float> z, V u, V v, float missing) {
    const hn::RebindToSigned<D> di;
    const auto nearest = [&](V place, int size) HWY_ATTR {
        const auto at = hn::Add(place, hn::Set(d, 0.5f));
        const auto last = hn::Set(d, static_cast<float>(size - 1));
        return truncated(di, hn::Min(hn::Max(at, hn::Zero(d)), last));
    };
    const auto x = nearest(u, z.width()), y = nearest(v, z.height());
    const auto point = gather(d, z.data(), hn::Add(hn::Mul(y, hn::Set(di, z.stride())), x));
    const auto hole = hn::RebindMask(d, hn::Eq(hn::BitCast(di, point), hn::Zero(di)));
    return hn::IfThenElse(hole, hn::Set(d, missing), hn::Div(hn::Set(d, 1.0f), point));
}

/// Moves places by the parallax of what is there, if points are searched for. Returns the inverse
/// depths of the points that are seen at the places, 1/m; if they are not searched for, of the
/// corners.
template <bool searched, class D, class V>
HWY_API V move_by_parallax(D d, const MappedTile &tile, ImageView<const float> z, V &u, V &v) {
    const auto parallax = parallax_of(d, tile);
    if constexpr (searched) {
        const auto inverse_depth = inverse_depth_near(d, z, u, v, tile.farthest_inverse_depth);
        const auto excess = hn::Sub(inverse_depth, parallax.inverse_depth);
        u = hn::Sub(u, hn::Mul(parallax.u, excess));
        v = hn::Sub(v, hn::Mul(parallax.v, excess));
        return inverse_depth;
    } else {
        return parallax.inverse_depth;
    }
}

/// The nearest points to some places, metres; 0 where the place is outside of the surface's
/// picture. `x`, `y`: their columns and rows.
template <class D, class V>
HWY_API V point_near(D d, ImageView<const float> z, V u, V v, hn::Vec<hn::RebindToSigned<D>> &x,
                     hn::Vec<hn::RebindToSigned<D>> &y) {
    const hn::RebindToSigned<D> di;
    const hn::RebindToUnsigned<D> du;
    const auto half = hn::Set(d, 0.5f);
    x = truncated(di, hn::Add(u, half));
    y = truncated(di, hn::Add(v, half));
    const auto inside = [&](auto place, int end) HWY_ATTR {
        return hn::RebindMask(
            di, hn::Lt(hn::BitCast(du, place), hn::Set(du, static_cast<std::uint32_t>(end))));
    };
    const auto in_picture = hn::And(inside(x, z.width()), inside(y, z.height()));
    const auto place = hn::Add(hn::Mul(y, hn::Set(di, z.stride())), x);
    const auto point = gather(d, z.data(), hn::IfThenElseZero(in_picture, place));
    return hn::IfThenElseZero(hn::RebindMask(d, in_picture), point);
}

/// Readings, whole millimetres, of depths, metres; `there`: 0 elsewhere.
template <class D, class V, class M>
HWY_API auto reading_of(D d, V depth, V scale, V shift, M there) {
    const hn::RebindToSigned<D> di;
    const auto exact = hn::Add(hn::Mul(depth, scale), hn::Add(shift, hn::Set(d, 0.5f)));
    return hn::DemoteTo(hn::Rebind<std::uint16_t, D>(),
                        hn::IfThenElseZero(there, truncated(di, exact)));
}

} // namespace
} // namespace afterglow::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#endif
