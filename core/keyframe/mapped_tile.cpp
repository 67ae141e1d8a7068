// SPDX-License-Identifier: Apache-2.0
// Compiled once for each instruction set; the best of them is chosen when first called.
#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "core/keyframe/mapped_tile.cpp"
#include "core/keyframe/mapped_tile.hpp"

#include "core/keyframe/parallax_tile.hpp"

#include <algorithm>
#include <cstring>
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

template <bool in_picture>
int draw_surface(const MappedTile &tile, ImageView<const float> z, int least_edge_distance,
                 const DrawnTile &to) {
    const hn::CappedTag<float, mapped_tile_px> d;
    const hn::RebindToSigned<decltype(d)> di;
    const MappedCorner &a = tile.corners[0], &b = tile.corners[1];
    const MappedCorner &c = tile.corners[2], &e = tile.corners[3];
    const auto [by_u, by_v] = slope_between(tile);
    const auto below_least = hn::Set(di, least_edge_distance - 1);
    auto found = hn::Zero(di);
    for (int i = 0; i < mapped_tile_px; i += static_cast<int>(hn::Lanes(d))) {
        // Places are half a pixel more, so that what is below is the nearest pixel.
        auto u = between(d, i, a.u + 0.5f, b.u + 0.5f, c.u + 0.5f, e.u + 0.5f);
        auto v = between(d, i, a.v + 0.5f, b.v + 0.5f, c.v + 0.5f, e.v + 0.5f);
        auto scale = between(d, i, a.scale, b.scale, c.scale, e.scale);
        const auto shifted = [slope = by_u + by_v](const MappedCorner &corner) {
            return corner.shift - 0.5f * slope * corner.scale + 0.5f;
        };
        auto shift = between(d, i, shifted(a), shifted(b), shifted(c), shifted(e));
        DrawnColumns columns(to, i);
        for (int row = 0; row < mapped_tile_px; ++row) {
            const auto x = hn::ConvertTo(di, u.value), y = hn::ConvertTo(di, v.value);
            auto offset = hn::Add(hn::Mul(y, hn::Set(di, z.stride())), x);
            hn::Mask<decltype(di)> on_picture;
            if constexpr (!in_picture) {
                const hn::RebindToUnsigned<decltype(d)> du;
                const auto inside = [&](auto place, int end) HWY_ATTR {
                    return hn::RebindMask(di, hn::Lt(hn::BitCast(du, place),
                                                     hn::Set(du, static_cast<std::uint32_t>(end))));
                };
                on_picture = hn::And(inside(x, z.width()), inside(y, z.height()));
                offset = hn::IfThenElseZero(on_picture, offset);
            }
            const auto point = hn::GatherIndex(d, z.data(), offset);
            const auto right = hn::Sub(u.value, hn::ConvertTo(d, x));
            const auto down = hn::Sub(v.value, hn::ConvertTo(d, y));
            const auto depth = hn::Add(
                point, hn::Add(hn::Mul(hn::Set(d, by_u), right), hn::Mul(hn::Set(d, by_v), down)));
            const auto edge = edge_of(d, point);
            auto there = hn::Gt(edge, below_least);
            if constexpr (!in_picture)
                there = hn::And(there, on_picture);
            found = hn::Sub(found, hn::VecFromMask(di, there));
            columns.draw(d, hn::Add(hn::Mul(depth, scale.value), shift.value), edge, there);
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
    const auto draw_it = tile.in_picture ? draw_surface<true> : draw_surface<false>;
    return draw_it(tile, z, least_edge_distance, {millimetres, edge_distance});
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
