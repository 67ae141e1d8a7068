// SPDX-License-Identifier: Apache-2.0
// Compiled once for each instruction set; the best of them is chosen when first called.
#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "core/warp/corner_kernels.cpp"
#include "core/warp/corner_kernels.hpp"

#include "core/warp/mapped_tile.hpp"

#include <cstddef>
#include <cstdint>
#include <hwy/cache_control.h>
#include <hwy/foreach_target.h>
#include <hwy/highway.h>
#include <numbers>

// clang-format off: after Highway, once for each instruction set
#include "core/base/lanes-inl.hpp"
// clang-format on

HWY_BEFORE_NAMESPACE();
namespace afterglow::HWY_NAMESPACE {
namespace {

/// How far a corner's point on the surface may be seen from the corner, pixels.
constexpr float corner_tolerance_px = 0.03f;

void view_rays(const ViewRow &given, float step, int count, const ViewRays &to) {
    const ViewRow row = given; // nothing written here can change a copy
    const ViewRays out = to;
    for_overlapping_lanes(count, [&](auto d, int i) HWY_ATTR {
        using V = hn::Vec<decltype(d)>;
        const auto set = [&](float value) HWY_ATTR { return hn::Set(d, value); };
        const auto column = hn::Mul(set(step), ramp(d, i));
        const auto along = [&](int k) HWY_ATTR {
            return hn::Add(hn::Mul(set(row.by_column[k]), column), set(row.origin[k]));
        };
        const auto inverse = hn::Div(set(1.0f), along(2));
        V u = hn::Mul(inverse, along(0)), v = hn::Mul(inverse, along(1));
        V parallax_u = hn::Sub(hn::Mul(set(row.shift[2]), u), set(row.shift[0]));
        V parallax_v = hn::Sub(hn::Mul(set(row.shift[2]), v), set(row.shift[1]));
        V scale = inverse;
        if (row.skewed) {
            // A point moves with its row on the surface, which moves with the point.
            struct Move {
                V by_row_u, by_row_v, turned_depth, rows;
            };
            const auto move_from = [&](V at_u, V at_v) HWY_ATTR {
                const auto turned = [&](int k) HWY_ATTR {
                    return hn::Add(hn::Add(hn::Mul(set(row.turn_per_row(k, 0)), at_u),
                                           hn::Mul(set(row.turn_per_row(k, 1)), at_v)),
                                   set(row.turn_per_row(k, 2)));
                };
                const auto depth = turned(2);
                const auto by_row_u = hn::Sub(hn::Mul(at_u, depth), turned(0));
                const auto by_row_v = hn::Sub(hn::Mul(at_v, depth), turned(1));
                return Move{by_row_u, by_row_v, depth,
                            hn::Div(hn::Sub(v, set(row.middle)), hn::Sub(set(1.0f), by_row_v))};
            };
            const Move first = move_from(u, v);
            const auto half = hn::Mul(set(0.5f), first.rows);
            const Move move = move_from(hn::Add(u, hn::Mul(half, first.by_row_u)),
                                        hn::Add(v, hn::Mul(half, first.by_row_v)));
            const auto nearer = hn::Div(parallax_v, hn::Sub(set(1.0f), move.by_row_v));
            u = hn::Add(u, hn::Mul(move.rows, move.by_row_u));
            v = hn::Add(v, hn::Mul(move.rows, move.by_row_v));
            parallax_u = hn::Add(parallax_u, hn::Mul(nearer, move.by_row_u));
            parallax_v = hn::Add(parallax_v, hn::Mul(nearer, move.by_row_v));
            scale = hn::Add(scale, hn::Mul(hn::Mul(scale, move.rows), move.turned_depth));
        }
        hn::StoreU(u, d, out.infinite_u + i);
        hn::StoreU(v, d, out.infinite_v + i);
        hn::StoreU(parallax_u, d, out.parallax_u + i);
        hn::StoreU(parallax_v, d, out.parallax_v + i);
        hn::StoreU(scale, d, out.scale + i);
        hn::StoreU(hn::Mul(inverse, set(row.shift[2])), d, out.shift + i);
    });
}

/// Columns and rows on the surface, pixels, of several rays.
template <class V>
struct Pixels {
    V u, v;
};
template <class D, class V = hn::Vec<D>>
HWY_API V squared_length(D /*tag*/, const Pixels<V> &way) {
    return hn::Add(hn::Mul(way.u, way.u), hn::Mul(way.v, way.v));
}
/// The points with that inverse depth, 1/m, of the i-th ray and those after it.
template <class D, class V = hn::Vec<D>>
HWY_API Pixels<V> place(D d, const ViewRays &rays, int i, V inverse_depth) {
    const auto load = [&](const float *from) HWY_ATTR { return hn::LoadU(d, from + i); };
    return {hn::Add(load(rays.infinite_u), hn::Mul(inverse_depth, load(rays.parallax_u))),
            hn::Add(load(rays.infinite_v), hn::Mul(inverse_depth, load(rays.parallax_v)))};
}

void parallax(const SeenOnTiles &given, float *HWY_RESTRICT pixels) {
    const SeenOnTiles tiles = given;
    for_overlapping_lanes(tiles.count, [&](auto d, int i) HWY_ATTR {
        constexpr float diagonal_px = std::numbers::sqrt2_v<float> * mapped_tile_px;
        using V = hn::Vec<decltype(d)>;
        const auto one = hn::Set(d, 1.0f);
        const auto near = hn::Div(one, hn::LoadU(d, tiles.nearest + i));
        const auto far = hn::Div(one, hn::LoadU(d, tiles.farthest + i));
        // Parallax and the tile's diagonal, both on the surface.
        const Pixels<V> by_depth = {hn::LoadU(d, tiles.left_above.parallax_u + i),
                                    hn::LoadU(d, tiles.left_above.parallax_v + i)};
        const auto a = place(d, tiles.left_above, i, near),
                   b = place(d, tiles.right_below, i, near);
        const auto moved = hn::Mul(hn::Sub(near, far), hn::Sqrt(squared_length(d, by_depth)));
        const auto diagonal =
            hn::Sqrt(squared_length(d, Pixels<V>{hn::Sub(b.u, a.u), hn::Sub(b.v, a.v)}));
        hn::StoreU(hn::Div(hn::Mul(moved, hn::Set(d, diagonal_px)), diagonal), d, pixels + i);
    });
}

/// The depths at places on the surface or, where that is a hole or outside, of one of the nearest
/// pieces around that have any; 0 where there is none nearby, and where it is not `wanted`.
template <class D, class V = hn::Vec<D>, class M>
HWY_API V depths_near(D d, const CornerSearch &search, const Pixels<V> &at, M wanted) {
    constexpr float beside = mapped_tile_px; // so far outside of the picture, pixels
    const hn::RebindToSigned<D> di;
    const auto last = [](int size) { return static_cast<float>(size - 1); };
    const auto within = [&](V place, float end) HWY_ATTR {
        const auto from_outside = order(d, hn::Add(place, hn::Set(d, beside)));
        return hn::And(hn::Gt(from_outside, hn::Zero(di)),
                       hn::Lt(from_outside, order(d, hn::Set(d, end + 2 * beside))));
    };
    const float right = last(search.z.width()), bottom = last(search.z.height());
    const auto there = hn::And(wanted, hn::And(within(at.u, right), within(at.v, bottom)));
    const auto nearest = [&](V place, float end) HWY_ATTR {
        const auto inside = hn::Min(hn::Max(place, hn::Zero(d)), hn::Set(d, end));
        return hn::IfThenElseZero(there, truncated(di, hn::Add(inside, hn::Set(d, 0.5f))));
    };
    const auto x = nearest(at.u, right), y = nearest(at.v, bottom);
    const auto at_row = [&](auto row) HWY_ATTR {
        const auto stride = hn::Set(di, static_cast<std::int32_t>(search.z.stride()));
        return hn::Add(hn::Mul(row, stride), x);
    };
    auto z = gather(d, search.z.data(), at_row(y));
    // Fetches what the corners one row of tiles below will read first: it is about a tile's height
    // below these points.
    HWY_ALIGN std::int32_t below[hn::MaxLanes(D())];
    hn::Store(at_row(hn::Min(hn::Add(y, hn::Set(di, mapped_tile_px)),
                             hn::Set(di, search.z.height() - 1))),
              di, below);
    for (const std::int32_t place : below)
        hwy::Prefetch(search.z.data() + place);
    z = hn::IfThenElseZero(hn::RebindMask(d, there), z);
    if (hn::AllFalse(di, hn::And(there, hn::Eq(order(d, z), hn::Zero(di)))))
        return z;
    constexpr std::size_t lanes = hn::MaxLanes(D());
    HWY_ALIGN float depths[lanes];
    HWY_ALIGN std::int32_t columns[lanes], rows[lanes], looked_up[lanes];
    hn::Store(z, d, depths);
    hn::Store(x, di, columns);
    hn::Store(y, di, rows);
    hn::Store(hn::VecFromMask(di, there), di, looked_up);
    for (std::size_t i = 0; i < hn::Lanes(d); ++i)
        if (looked_up[i] != 0 && depths[i] == 0.0f)
            depths[i] = search.pieces.nearest_around(columns[i], rows[i]);
    return hn::Load(d, depths);
}

void corners(const CornerSearch &search, const ViewRays &given, const float *first,
             const float *millimetres, int count, const FoundCorners &to) {
    constexpr int lookups = 3; // with noisy readings places may not converge
    const ViewRays rays = given;
    const FoundCorners out = to;
    for_overlapping_lanes(count, [&](auto d, int i) HWY_ATTR {
        using V = hn::Vec<decltype(d)>;
        const hn::RebindToSigned<decltype(d)> di;
        const auto one = hn::Set(d, 1.0f);
        const auto is_depth = [&](V z) HWY_ATTR { return hn::Ne(order(d, z), hn::Zero(di)); };
        V z = hn::LoadU(d, first + i);
        auto searched = is_depth(z);
        Pixels<V> at = place(d, rays, i, hn::Div(one, z));
        for (int k = 0; k < lookups && !hn::AllFalse(di, searched); ++k) {
            z = hn::IfThenElse(hn::RebindMask(d, searched), depths_near(d, search, at, searched),
                               z);
            const Pixels<V> before = at;
            at = place(d, rays, i, hn::Div(one, z));
            const auto moved =
                squared_length(d, Pixels<V>{hn::Sub(at.u, before.u), hn::Sub(at.v, before.v)});
            const auto near_enough = hn::Lt(
                order(d, moved), order(d, hn::Set(d, corner_tolerance_px * corner_tolerance_px)));
            searched = hn::And(searched, hn::And(is_depth(z), hn::Not(near_enough)));
        }
        const auto scale = hn::LoadU(d, rays.scale + i), shift = hn::LoadU(d, rays.shift + i);
        const auto depth = order(d, hn::Add(hn::Mul(scale, z), shift));
        const auto in_range = hn::Not(hn::Or(hn::Lt(depth, order(d, hn::Set(d, search.nearest))),
                                             hn::Gt(depth, order(d, hn::Set(d, search.farthest)))));
        const auto units = hn::LoadU(d, millimetres + i);
        hn::StoreU(at.u, d, out.u + i);
        hn::StoreU(at.v, d, out.v + i);
        hn::StoreU(hn::IfThenElseZero(hn::RebindMask(d, in_range), z), d, out.z + i);
        hn::StoreU(hn::Mul(units, scale), d, out.scale + i);
        hn::StoreU(hn::Mul(units, shift), d, out.shift + i);
    });
}

} // namespace
} // namespace afterglow::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace afterglow {
namespace {

HWY_EXPORT(view_rays);
HWY_EXPORT(parallax);
HWY_EXPORT(corners);

} // namespace

void find_view_rays(const ViewRow &row, float step, int count, const ViewRays &rays) {
    HWY_DYNAMIC_DISPATCH(view_rays)(row, step, count, rays);
}

void find_parallax(const SeenOnTiles &tiles, float *pixels) {
    HWY_DYNAMIC_DISPATCH(parallax)(tiles, pixels);
}

void find_corners(const CornerSearch &search, const ViewRays &rays, const float *first,
                  const float *millimetres, int count, const FoundCorners &corners) {
    HWY_DYNAMIC_DISPATCH(corners)(search, rays, first, millimetres, count, corners);
}

} // namespace afterglow
#endif
