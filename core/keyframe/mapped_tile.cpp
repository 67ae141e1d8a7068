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

/// rise() from the points of a tile that is not of one surface, at those columns and rows, to
/// places that are `along` columns and `down` rows from where the corners put the points.
template <class D, class V, class VI>
HWY_API V rise_around(D d, const MappedTile &tile, ImageView<const float> z, VI column, VI row,
                      V depth, V along, V down) {
    const hn::RebindToSigned<D> di;
    const hn::RebindToUnsigned<D> du;
    const auto stride = hn::Set(di, z.stride()), one = hn::Set(di, 1);
    const auto within = [&](VI at, int size) HWY_ATTR {
        const auto last = hn::Set(du, static_cast<std::uint32_t>(size - 2));
        return hn::RebindMask(di, hn::Lt(hn::BitCast(du, hn::Sub(at, one)), last));
    };
    const auto has_neighbours = hn::And(within(column, z.width()), within(row, z.height()));
    const auto offset =
        hn::IfThenElse(has_neighbours, hn::Add(hn::Mul(row, stride), column), hn::Add(stride, one));
    const auto at = [&](VI place) HWY_ATTR { return hn::GatherIndex(d, z.data(), place); };
    const Around<V> around = {at(hn::Sub(offset, one)), at(hn::Add(offset, one)),
                              at(hn::Sub(offset, stride)), at(hn::Add(offset, stride))};
    const auto edge = hn::IfThenElseZero(has_neighbours, edge_of(d, depth));
    const auto nearer = hn::Sub(hn::Div(hn::Set(d, 1.0f), depth), hn::Set(d, tile.inverse_depth));
    return rise(d, edge, around, depth,
                hn::Sub(along, hn::Mul(hn::Set(d, tile.parallax_u), nearer)),
                hn::Sub(down, hn::Mul(hn::Set(d, tile.parallax_v), nearer)));
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
    const auto across = hn::Set(d, by_u), down = hn::Set(d, by_v);
    const auto below_least = hn::Set(di, least_edge_distance - 1);
    const float *const depths = z.data();
    const auto depth_stride = hn::Set(di, z.stride());
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
            const auto x = hn::ConvertTo(di, u.value), y = hn::ConvertTo(di, v.value);
            auto offset = hn::Add(hn::Mul(y, depth_stride), x);
            hn::Mask<decltype(di)> on_picture;
            if constexpr (!in_picture) {
                const hn::RebindToUnsigned<decltype(d)> du;
                const auto inside = [&](auto at, int end) HWY_ATTR {
                    return hn::RebindMask(di, hn::Lt(hn::BitCast(du, at),
                                                     hn::Set(du, static_cast<std::uint32_t>(end))));
                };
                on_picture = hn::And(inside(x, z.width()), inside(y, z.height()));
                offset = hn::IfThenElseZero(on_picture, offset);
            }
            const auto depth = hn::GatherIndex(d, depths, offset);
            const auto along = hn::Sub(u.value, hn::ConvertTo(d, x));
            const auto downwards = hn::Sub(v.value, hn::ConvertTo(d, y));
            hn::Vec<decltype(d)> moved_by;
            if constexpr (one_surface)
                moved_by = hn::Add(hn::Mul(across, along), hn::Mul(down, downwards));
            else {
                const auto half = hn::Set(d, 0.5f);
                moved_by = rise_around(d, tile, z, x, y, depth, hn::Sub(along, half),
                                       hn::Sub(downwards, half));
            }
            const auto reading =
                hn::Add(hn::Mul(hn::Add(depth, moved_by), scale.value), shift.value);
            const auto edge = edge_of(d, depth);
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
