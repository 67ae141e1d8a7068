// SPDX-License-Identifier: Apache-2.0
// Compiled once for each instruction set; the best of them is chosen when first called.
#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "core/keyframe/mapped_tile.cpp"
#include "core/keyframe/mapped_tile.hpp"

#include <algorithm>
#include <cstring>
#include <hwy/foreach_target.h>
#include <hwy/highway.h>

// clang-format off: after Highway, once for each instruction set
#include "core/base/lanes-inl.hpp"
#include "core/keyframe/surface_point-inl.hpp"
// clang-format on

HWY_BEFORE_NAMESPACE();
namespace afterglow::HWY_NAMESPACE {
namespace {

/// A value that is bilinear between a tile's corners, in columns of vectors: at the first row, and
/// the step to the next one.
template <class V>
struct Bilinear {
    V value, step;
};

/// The depths of four neighbours, metres, 0 = none: at the left and right, then below.
template <class V>
struct Neighbours {
    V a, b, c, e;
};
/// Those whose first one is at that place of the surface's depths.
template <class D, class VI>
HWY_API Neighbours<hn::Vec<D>> neighbours_at(D d, ImageView<const float> z, VI place) {
    const float *const upper = z.data(), *const lower = z.row(1);
#if HWY_TARGET != HWY_SCALAR // which has no pairs
    // Such instruction sets load two at once, but look up one by one.
    if constexpr (hn::MaxLanes(D()) == 4) {
        const hn::Half<D> pair;
        HWY_ALIGN std::int32_t at[4];
        hn::Store(place, hn::RebindToSigned<D>(), at);
        const auto two = [&](const float *from, int i) HWY_ATTR {
            return hn::Combine(d, hn::LoadU(pair, from + at[i + 1]), hn::LoadU(pair, from + at[i]));
        };
        const auto above = two(upper, 0), above2 = two(upper, 2);
        const auto below = two(lower, 0), below2 = two(lower, 2);
        return {hn::ConcatEven(d, above2, above), hn::ConcatOdd(d, above2, above),
                hn::ConcatEven(d, below2, below), hn::ConcatOdd(d, below2, below)};
    }
#endif
    return {hn::GatherIndex(d, upper, place), hn::GatherIndex(d, upper + 1, place),
            hn::GatherIndex(d, lower, place), hn::GatherIndex(d, lower + 1, place)};
}

/// What is seen at places of a tile that is not of one surface: the nearest point, and the depth,
/// metres, at the place itself. This is bilinear between the four points around the place, moved by
/// the point's parallax, unless one of them is missing or the point is beside an edge: they may be
/// of another surface.
template <class V>
struct SeenPoint {
    V point, depth;
};
template <class D, class V>
HWY_API SeenPoint<V> seen_at(D d, const MappedTile &tile, ImageView<const float> z, V u, V v) {
    const hn::RebindToSigned<D> di;
    const hn::RebindToUnsigned<D> du;
    const auto first = [&](V place, int size) HWY_ATTR {
        const auto whole = hn::ConvertTo(di, place);
        return hn::Min(hn::Max(whole, hn::Zero(di)), hn::Set(di, size - 2));
    };
    const auto column = first(u, z.width()), row = first(v, z.height());
    const auto from = hn::Add(hn::Mul(row, hn::Set(di, z.stride())), column);
    const auto [a, b, c, e] = neighbours_at(d, z, from);
    const auto right = hn::Sub(u, hn::ConvertTo(d, column));
    const auto down = hn::Sub(v, hn::ConvertTo(d, row));
    const auto half = order(d, hn::Set(d, 0.5f));
    const auto is_right = hn::RebindMask(d, hn::Not(hn::Lt(order(d, right), half)));
    const auto is_below = hn::RebindMask(d, hn::Not(hn::Lt(order(d, down), half)));
    const auto point =
        hn::IfThenElse(is_below, hn::IfThenElse(is_right, e, c), hn::IfThenElse(is_right, b, a));
    const auto bits = [&](V value) HWY_ATTR { return hn::BitCast(du, value); };
    const auto least = hn::Min(hn::Min(bits(a), bits(b)), hn::Min(bits(c), bits(e)));
    const auto inside = hn::And(hn::Gt(edge_of(d, point), hn::Set(di, beside_edge)),
                                hn::RebindMask(di, hn::Ne(least, hn::Zero(du))));
    const auto inverse = hn::Sub(hn::Div(hn::Set(d, 1.0f), point), hn::Set(d, tile.inverse_depth));
    const auto x = hn::Sub(right, hn::Mul(hn::Set(d, tile.parallax_u), inverse));
    const auto y = hn::Sub(down, hn::Mul(hn::Set(d, tile.parallax_v), inverse));
    const auto across = hn::Sub(b, a);
    const auto above = hn::Add(a, hn::Mul(x, across));
    const auto step = hn::Add(hn::Sub(c, a), hn::Mul(x, hn::Sub(hn::Sub(e, c), across)));
    const auto between = hn::Add(above, hn::Mul(y, step));
    const auto most = hn::Mul(hn::Set(d, 1 + steepest), point);
    const auto limited = hn::Max(hn::Min(between, most), hn::Mul(hn::Set(d, 1 - steepest), point));
    return {point, hn::IfThenElse(hn::RebindMask(d, inside), limited, point)};
}

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

/// An even tile is looked up at the pixels of a grid: so many pixels apart, so many across.
constexpr int grid_px = 4, grid_across = mapped_tile_px / grid_px + 1;
/// The grid's pixels row by row, filled up to whole vectors: where each is, shares of the tile.
constexpr int grid_pixels = 32;
struct GridPlaces {
    HWY_ALIGN float x[grid_pixels], y[grid_pixels];
};
constexpr GridPlaces grid = [] {
    GridPlaces places{};
    for (int y = 0; y < grid_across; ++y)
        for (int x = 0; x < grid_across; ++x) {
            places.x[y * grid_across + x] = static_cast<float>(x) / (grid_across - 1);
            places.y[y * grid_across + x] = static_cast<float>(y) / (grid_across - 1);
        }
    return places;
}();

/// The readings at the grid's pixels, millimetres, plus 0.5 for rounding. False if one of these is
/// a hole or not far from edges.
bool read_grid(const MappedTile &tile, ImageView<const float> z, float *HWY_RESTRICT readings) {
    const hn::CappedTag<float, grid_pixels> d;
    const hn::RebindToSigned<decltype(d)> di;
    const MappedCorner &a = tile.corners[0], &b = tile.corners[1];
    const MappedCorner &c = tile.corners[2], &e = tile.corners[3];
    const auto [by_u, by_v] = slope_between(tile);
    const auto half = hn::Set(d, 0.5f);
    auto edges = hn::Set(di, edge_distance_bits); // the bits that all have
    for (int i = 0; i < grid_across * grid_across; i += static_cast<int>(hn::Lanes(d))) {
        const auto x = hn::Load(d, grid.x + i), y = hn::Load(d, grid.y + i);
        const auto between = [&](float MappedCorner::*of) HWY_ATTR {
            const float right = b.*of - a.*of, down = c.*of - a.*of;
            const auto step =
                hn::Add(hn::Set(d, down), hn::Mul(x, hn::Set(d, e.*of - c.*of - right)));
            return hn::Add(hn::Add(hn::Set(d, a.*of), hn::Mul(x, hn::Set(d, right))),
                           hn::Mul(y, step));
        };
        const auto u = between(&MappedCorner::u), v = between(&MappedCorner::v);
        const auto column = hn::ConvertTo(di, hn::Add(u, half));
        const auto row = hn::ConvertTo(di, hn::Add(v, half));
        const auto depth =
            hn::GatherIndex(d, z.data(), hn::Add(hn::Mul(row, hn::Set(di, z.stride())), column));
        edges = hn::And(edges, edge_of(d, depth));
        const auto moved_by =
            hn::Add(hn::Mul(hn::Set(d, by_u), hn::Sub(u, hn::ConvertTo(d, column))),
                    hn::Mul(hn::Set(d, by_v), hn::Sub(v, hn::ConvertTo(d, row))));
        const auto reading =
            hn::Add(hn::Mul(hn::Add(depth, moved_by), between(&MappedCorner::scale)),
                    between(&MappedCorner::shift));
        hn::Store(hn::Add(reading, half), d, readings + i);
    }
    return hn::AllTrue(di, hn::Eq(edges, hn::Set(di, far_from_edge)));
}

/// Draws an even tile: readings are bilinear between those of the grid. Returns how many they are.
int draw_even(const float *HWY_RESTRICT readings, ImageView<std::uint16_t> millimetres,
              ImageView<std::uint8_t> edge_distance) {
    const hn::CappedTag<float, grid_px> of_cell;
    const hn::CappedTag<float, mapped_tile_px> d;
    const hn::RebindToSigned<decltype(d)> di;
    const hn::Rebind<std::uint16_t, decltype(d)> d16;
    constexpr float part = 1.0f / grid_px;
    HWY_ALIGN float lines[grid_across][mapped_tile_px];
    for (int y = 0; y < grid_across; ++y)
        for (int x = 0; x < mapped_tile_px; x += static_cast<int>(hn::Lanes(of_cell))) {
            const float *const from = readings + y * grid_across + x / grid_px;
            const auto across = hn::Mul(ramp(of_cell, x % grid_px), hn::Set(of_cell, part));
            hn::Store(hn::Add(hn::Set(of_cell, from[0]),
                              hn::Mul(across, hn::Set(of_cell, from[1] - from[0]))),
                      of_cell, lines[y] + x);
        }
    for (int y = 0; y < mapped_tile_px; y += grid_px)
        for (int x = 0; x < mapped_tile_px; x += static_cast<int>(hn::Lanes(d))) {
            auto reading = hn::Load(d, lines[y / grid_px] + x);
            const auto next = hn::Load(d, lines[y / grid_px + 1] + x);
            const auto step = hn::Mul(hn::Sub(next, reading), hn::Set(d, part));
            for (int row = y; row < y + grid_px; ++row) {
                hn::StoreU(hn::DemoteTo(d16, hn::ConvertTo(di, reading)), d16,
                           millimetres.row(row) + x);
                reading = hn::Add(reading, step);
            }
        }
    for (int row = 0; row < mapped_tile_px; ++row)
        std::memset(edge_distance.row(row), far_from_edge, mapped_tile_px);
    return mapped_tile_px * mapped_tile_px;
}

template <bool in_picture, bool one_surface>
int draw_tile(const MappedTile &tile, ImageView<const float> z, int least_edge_distance,
              ImageView<std::uint16_t> millimetres, ImageView<std::uint8_t> edge_distance) {
    const hn::CappedTag<float, mapped_tile_px> d;
    const hn::RebindToSigned<decltype(d)> di;
    const hn::Rebind<std::uint16_t, decltype(d)> d16;
    const hn::Rebind<std::uint8_t, decltype(d)> d8;
    constexpr float part = 1.0f / mapped_tile_px;
    const MappedCorner &a = tile.corners[0], &b = tile.corners[1];
    const MappedCorner &c = tile.corners[2], &e = tile.corners[3];
    const auto [by_u, by_v] = one_surface ? slope_between(tile) : TileSlope{};
    const auto below_least = hn::Set(di, least_edge_distance - 1);
    auto found = hn::Zero(di);
    for (int i = 0; i < mapped_tile_px; i += static_cast<int>(hn::Lanes(d))) {
        const auto column = ramp(d, i);
        const auto between = [&](float at_a, float at_b, float at_c, float at_e) HWY_ATTR {
            const float step = part * (at_b - at_a);
            const auto first = hn::Add(hn::Set(d, at_a), hn::Mul(column, hn::Set(d, step)));
            const auto of_step = hn::Set(d, part * (part * (at_e - at_c) - step));
            return Bilinear<hn::Vec<decltype(d)>>{
                first, hn::Add(hn::Set(d, part * (at_c - at_a)), hn::Mul(column, of_step))};
        };
        // Places are half a pixel more, so that what is below is the nearest pixel.
        auto u = between(a.u + 0.5f, b.u + 0.5f, c.u + 0.5f, e.u + 0.5f);
        auto v = between(a.v + 0.5f, b.v + 0.5f, c.v + 0.5f, e.v + 0.5f);
        auto scale = between(a.scale, b.scale, c.scale, e.scale);
        const auto shifted = [slope = by_u + by_v](const MappedCorner &corner) {
            return corner.shift - 0.5f * slope * corner.scale + 0.5f;
        };
        auto shift = between(shifted(a), shifted(b), shifted(c), shifted(e));
        for (int row = 0; row < mapped_tile_px; ++row) {
            hn::Mask<decltype(di)> on_picture;
            if constexpr (!in_picture) {
                const hn::RebindToUnsigned<decltype(d)> du;
                const auto inside = [&](auto place, int end) HWY_ATTR {
                    const auto at = hn::BitCast(du, hn::ConvertTo(di, place));
                    return hn::RebindMask(di,
                                          hn::Lt(at, hn::Set(du, static_cast<std::uint32_t>(end))));
                };
                on_picture = hn::And(inside(u.value, z.width()), inside(v.value, z.height()));
            }
            hn::Vec<decltype(d)> point, depth;
            if constexpr (one_surface) {
                const auto x = hn::ConvertTo(di, u.value), y = hn::ConvertTo(di, v.value);
                auto offset = hn::Add(hn::Mul(y, hn::Set(di, z.stride())), x);
                if constexpr (!in_picture)
                    offset = hn::IfThenElseZero(on_picture, offset);
                point = hn::GatherIndex(d, z.data(), offset);
                const auto right = hn::Sub(u.value, hn::ConvertTo(d, x));
                const auto down = hn::Sub(v.value, hn::ConvertTo(d, y));
                depth = hn::Add(point, hn::Add(hn::Mul(hn::Set(d, by_u), right),
                                               hn::Mul(hn::Set(d, by_v), down)));
            } else {
                const auto half = hn::Set(d, 0.5f);
                const auto seen =
                    seen_at(d, tile, z, hn::Sub(u.value, half), hn::Sub(v.value, half));
                point = seen.point;
                depth = seen.depth;
            }
            const auto reading = hn::Add(hn::Mul(depth, scale.value), shift.value);
            const auto edge = edge_of(d, point);
            auto there = hn::Gt(edge, below_least);
            if constexpr (!in_picture)
                there = hn::And(there, on_picture);
            const auto whole = hn::IfThenElseZero(there, hn::ConvertTo(di, reading));
            found = hn::Sub(found, hn::VecFromMask(di, there));
            hn::StoreU(hn::DemoteTo(d16, whole), d16, millimetres.row(row) + i);
            hn::StoreU(hn::DemoteTo(d8, hn::IfThenElseZero(there, edge)), d8,
                       edge_distance.row(row) + i);
            for (auto *const of : {&u, &v, &scale, &shift})
                of->value = hn::Add(of->value, of->step);
        }
    }
    return hn::GetLane(hn::SumOfLanes(di, found));
}

int draw(const MappedTile &tile, ImageView<const float> z, int least_edge_distance,
         ImageView<std::uint16_t> millimetres, ImageView<std::uint8_t> edge_distance) {
    HWY_ALIGN float readings[grid_pixels];
    if (tile.even && read_grid(tile, z, readings))
        return draw_even(readings, millimetres, edge_distance);
    const auto draw_it = tile.in_picture
                             ? tile.one_surface ? draw_tile<true, true> : draw_tile<true, false>
                         : tile.one_surface ? draw_tile<false, true>
                                            : draw_tile<false, false>;
    return draw_it(tile, z, least_edge_distance, millimetres, edge_distance);
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
    return HWY_DYNAMIC_DISPATCH(draw)(tile, z, least_edge_distance, millimetres, edge_distance);
}

} // namespace afterglow
#endif
