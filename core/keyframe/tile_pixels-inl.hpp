// SPDX-License-Identifier: Apache-2.0
//
// Drawing of a mapped tile in vectors, whatever its pixels look up. Included once for each
// instruction set, like lanes-inl.hpp.
#if defined(AFTERGLOW_CORE_KEYFRAME_TILE_PIXELS_INL_HPP) == defined(HWY_TARGET_TOGGLE)
#ifdef AFTERGLOW_CORE_KEYFRAME_TILE_PIXELS_INL_HPP
#undef AFTERGLOW_CORE_KEYFRAME_TILE_PIXELS_INL_HPP
#else
#define AFTERGLOW_CORE_KEYFRAME_TILE_PIXELS_INL_HPP
#endif

#include "core/base/lanes-inl.hpp"
#include "core/keyframe/mapped_tile.hpp"
#include "core/keyframe/surface_point.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <cstring>
#include <hwy/highway.h>

HWY_BEFORE_NAMESPACE();
namespace afterglow::HWY_NAMESPACE {
namespace {

namespace hn = hwy::HWY_NAMESPACE;

/// Where a tile is drawn.
struct DrawnTile {
    ImageView<std::uint16_t> millimetres;
    ImageView<std::uint8_t> edge_distance;
};

/// The grid: the first pixel of each block of a tile, and those of the blocks of the next tiles
/// that are at its right and below. They are looked up first.
inline constexpr int block_px = mapped_block_px, blocks_across = mapped_tile_px / block_px;
inline constexpr int grid_across = blocks_across + 1;
/// So many pixels at once, at most: those of the grid, filled up to whole vectors.
inline constexpr int most_pixels = 32;

/// Columns and rows of the pixels of a square, row by row, each `step` from the next.
struct SquarePixels {
    HWY_ALIGN float x[most_pixels], y[most_pixels];
};
constexpr SquarePixels pixels_of_square(int across, int step) {
    SquarePixels pixels{};
    for (int i = 0; i < across * across; ++i) {
        const int column = i % across, row = i / across;
        pixels.x[i] = static_cast<float>(column * step);
        pixels.y[i] = static_cast<float>(row * step);
    }
    return pixels;
}
inline constexpr SquarePixels grid = pixels_of_square(grid_across, block_px);
inline constexpr SquarePixels block = pixels_of_square(block_px, 1);

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
/// What pixels of a tile look up, and how readings follow from it.
struct TilePlaces {
    BetweenCorners u, v, scale, shift;

    explicit TilePlaces(const MappedTile &tile)
        : u(tile, &MappedCorner::u), v(tile, &MappedCorner::v), scale(tile, &MappedCorner::scale),
          shift(tile, &MappedCorner::shift) {}
};

/// The grid's pixels, and what is seen there.
template <class D>
class SeenGrid {
public:
    static constexpr int lanes = static_cast<int>(hn::MaxLanes(D()));
    static constexpr int vectors = (grid_across * grid_across - 1) / lanes + 1;

    explicit SeenGrid(const TilePlaces &places) : places_(places) {}

    /// Values at the i-th vector of pixels.
    HWY_INLINE auto at(BetweenCorners TilePlaces::*of, int i) const {
        const D d;
        const BetweenCorners &value = places_.*of;
        const auto x = hn::Load(d, grid.x + i * lanes), y = hn::Load(d, grid.y + i * lanes);
        const auto step = hn::Add(hn::Set(d, value.down), hn::Mul(x, hn::Set(d, value.twist)));
        return hn::Add(hn::Add(hn::Set(d, value.at), hn::Mul(x, hn::Set(d, value.across))),
                       hn::Mul(y, step));
    }
    template <class V16, class VI, class V>
    HWY_INLINE void put(int i, V16 reading, VI edge, V inverse_depth) {
        const D d;
        hn::Store(reading, hn::Rebind<std::uint16_t, D>(), readings + i * lanes);
        hn::Store(edge, hn::RebindToSigned<D>(), edges + i * lanes);
        hn::Store(inverse_depth, d, inverse_depths + i * lanes);
    }

    HWY_ALIGN std::uint16_t readings[most_pixels]; ///< millimetres
    HWY_ALIGN std::int32_t edges[most_pixels];     ///< distances, pixels; 0: nothing is seen
    HWY_ALIGN float inverse_depths[most_pixels];   ///< of points that were searched for, 1/m

private:
    const TilePlaces &places_;
};

/// Draws pixels of a tile in columns: as many as a block has, or as a vector has lanes if that is
/// fewer. One vector holds pixels of one or several rows.
template <class D>
class DrawnColumns {
public:
    static constexpr int lanes = static_cast<int>(hn::MaxLanes(D()));
    static constexpr int columns = std::min(lanes, block_px), rows = lanes / columns;
    static constexpr int vectors = block_px / rows;

    DrawnColumns(const TilePlaces &places, int first, const DrawnTile &to)
        : u_(places.u, first), v_(places.v, first), scale_(places.scale, first),
          shift_(places.shift, first), to_(to), first_(first),
          found_(hn::Zero(hn::RebindToSigned<D>())) {}

    /// at() and put() are about the block whose first row is this row of the tile.
    void go_to(int row) { row_ = row; }
    HWY_INLINE auto at(BetweenCorners TilePlaces::*of, int i) const {
        const Value &value = of == &TilePlaces::u       ? u_
                             : of == &TilePlaces::v     ? v_
                             : of == &TilePlaces::scale ? scale_
                                                        : shift_;
        const auto row = hn::Set(D(), static_cast<float>(row_ + i * rows));
        return hn::Add(value.top, hn::Mul(row, value.step));
    }
    template <class V16, class VI, class V>
    HWY_INLINE void put(int i, V16 reading, VI edge, V /*inverse_depth*/) {
        const hn::RebindToSigned<D> di;
        const hn::Rebind<std::uint16_t, D> d16;
        const hn::Rebind<std::uint8_t, D> d8;
        const int row = row_ + i * rows;
        found_ = hn::Sub(found_, hn::VecFromMask(di, hn::Gt(edge, hn::Zero(di))));
        const auto edges = hn::DemoteTo(d8, edge);
        if constexpr (rows == 1) {
            hn::StoreU(reading, d16, to_.millimetres.row(row) + first_);
            hn::StoreU(edges, d8, to_.edge_distance.row(row) + first_);
        } else {
            HWY_ALIGN std::uint16_t readings_of_rows[rows][columns];
            HWY_ALIGN std::uint8_t edges_of_rows[rows][columns];
            hn::Store(reading, d16, readings_of_rows[0]);
            hn::Store(edges, d8, edges_of_rows[0]);
            for (int k = 0; k < rows; ++k) {
                std::memcpy(to_.millimetres.row(row + k) + first_, readings_of_rows[k],
                            sizeof readings_of_rows[k]);
                std::memcpy(to_.edge_distance.row(row + k) + first_, edges_of_rows[k],
                            sizeof edges_of_rows[k]);
            }
        }
    }
    int found() const { return hn::GetLane(hn::SumOfLanes(hn::RebindToSigned<D>(), found_)); }

private:
    /// A value at the lanes of a vector that begins on the tile's first row, and the step to the
    /// next row.
    struct Value {
        hn::Vec<D> top, step;

        Value(const BetweenCorners &value, int first) {
            const D d;
            const auto column =
                hn::Add(hn::Load(d, block.x), hn::Set(d, static_cast<float>(first)));
            step = hn::Add(hn::Set(d, value.down), hn::Mul(column, hn::Set(d, value.twist)));
            top = hn::Add(hn::Set(d, value.at), hn::Mul(column, hn::Set(d, value.across)));
            if constexpr (rows > 1)
                top = hn::Add(top, hn::Mul(hn::Load(d, block.y), step));
        }
    };
    Value u_, v_, scale_, shift_;
    DrawnTile to_;
    int first_, row_ = 0;
    hn::Vec<hn::RebindToSigned<D>> found_;
};

/// The quarters of the way from one value to another.
template <class V>
struct Quarters {
    V first, second, third;
};
template <class V>
HWY_API Quarters<V> quarters_between(V from, V to) {
    const hn::DFromV<V> d;
    const auto way = hn::Sub(to, from);
    const auto quarter = hn::ShiftRight<2>(hn::Add(way, hn::Set(d, 2)));
    return {hn::Add(from, quarter), hn::Add(from, hn::ShiftRight<1>(hn::Add(way, hn::Set(d, 1)))),
            hn::Sub(to, quarter)};
}

/// Draws the readings of all blocks of a tile bilinearly between those of the grid, millimetres.
/// Blocks that are not even are drawn over afterwards.
inline void draw_between(const std::uint16_t *HWY_RESTRICT grid_readings,
                         ImageView<std::uint16_t> millimetres) {
    static_assert(block_px == 4);
    const hn::CappedTag<std::int16_t, blocks_across> of_blocks;
    const hn::CappedTag<std::int16_t, mapped_tile_px> d;
    const hn::RebindToUnsigned<decltype(d)> d16;
    const auto *const readings = reinterpret_cast<const std::int16_t *>(grid_readings);
    HWY_ALIGN std::int16_t lines[grid_across][mapped_tile_px];
    for (int y = 0; y < grid_across; ++y)
        for (int x = 0; x < blocks_across; x += static_cast<int>(hn::Lanes(of_blocks))) {
            const auto from = hn::LoadU(of_blocks, readings + y * grid_across + x);
            const auto to = hn::LoadU(of_blocks, readings + y * grid_across + x + 1);
            const auto [first, second, third] = quarters_between(from, to);
            hn::StoreInterleaved4(from, first, second, third, of_blocks, lines[y] + x * block_px);
        }
    for (int y = 0; y < blocks_across; ++y)
        for (int x = 0; x < mapped_tile_px; x += static_cast<int>(hn::Lanes(d))) {
            const auto from = hn::Load(d, lines[y] + x), to = hn::Load(d, lines[y + 1] + x);
            const auto [first, second, third] = quarters_between(from, to);
            int row = y * block_px;
            for (const auto &reading : {from, first, second, third})
                hn::StoreU(hn::BitCast(d16, reading), d16, millimetres.row(row++) + x);
        }
}

/// Which blocks of a tile are even: the points seen at their corners, pixels of the grid, are of
/// one surface and not near an edge. Before find() none is.
class Blocks {
public:
    /// `most_apart`: how far from each other the inverse depths of points that were searched for
    /// may be on an even block, 1/m.
    template <bool searched, class Seen>
    void find(const Seen &seen, float most_apart) {
        const hn::CappedTag<float, blocks_across> d;
        const hn::RebindToSigned<decltype(d)> di;
        auto all = hn::Set(di, ~0);
        for (int y = 0; y < blocks_across; ++y)
            for (int x = 0; x < blocks_across; x += static_cast<int>(hn::Lanes(d))) {
                const int upper = y * grid_across + x, lower = upper + grid_across;
                const auto of_corners = [&](auto tag, const auto *values, auto join) HWY_ATTR {
                    return join(
                        join(hn::LoadU(tag, values + upper), hn::LoadU(tag, values + upper + 1)),
                        join(hn::LoadU(tag, values + lower), hn::LoadU(tag, values + lower + 1)));
                };
                const auto add = [](auto a, auto b) HWY_ATTR { return hn::Add(a, b); };
                const auto least = [](auto a, auto b) HWY_ATTR { return hn::Min(a, b); };
                const auto most = [](auto a, auto b) HWY_ATTR { return hn::Max(a, b); };
                auto even =
                    hn::Gt(of_corners(di, seen.edges, least), hn::Set(di, edge_free_block - 1));
                if constexpr (searched) {
                    const auto apart = hn::Sub(of_corners(d, seen.inverse_depths, most),
                                               of_corners(d, seen.inverse_depths, least));
                    even =
                        hn::And(even, hn::RebindMask(di, hn::Lt(order(d, apart),
                                                                order(d, hn::Set(d, most_apart)))));
                }
                const auto sum = of_corners(di, seen.edges, add);
                const auto edge = hn::IfThenElseZero(even, hn::ShiftRight<2>(sum));
                all = hn::And(all, hn::VecFromMask(di, even));
                hn::Store(edge, di, edge_[y] + x);
            }
        all_even_ = hn::AllTrue(di, hn::Ne(all, hn::Zero(di)));
    }

    bool all_even() const { return all_even_; }
    bool even(int x, int y) const { return edge_[y][x] > 0; }
    /// Draws the edge distances: of even blocks the mean of their corners'.
    void draw_edges(ImageView<std::uint8_t> edge_distance) const {
        for (int y = 0; y < blocks_across; ++y) {
            std::array<std::uint32_t, blocks_across> words; // four pixels each
            for (std::size_t x = 0; x < words.size(); ++x)
                words[x] = 0x01010101u * static_cast<std::uint32_t>(edge_[y][x]);
            for (int row = y * block_px; row < (y + 1) * block_px; ++row)
                std::memcpy(edge_distance.row(row), words.data(), sizeof words);
        }
    }

private:
    HWY_ALIGN std::int32_t edge_[blocks_across][blocks_across] = {}; ///< 0: not even
    bool all_even_ = false;
};

/// Draws the blocks of a column that are not even, pixel by pixel; returns how many pixels have
/// depth.
template <class LookUp>
HWY_NOINLINE int draw_uneven(const LookUp &look_up, const Blocks &blocks, int x,
                             const DrawnTile &to) {
    using D = hn::CappedTag<float, block_px * block_px>;
    int found = 0;
    for (int column = x * block_px; column < (x + 1) * block_px;
         column += DrawnColumns<D>::columns) {
        DrawnColumns<D> columns(look_up.places(), column, to);
        for (int y = 0; y < blocks_across; ++y)
            if (!blocks.even(x, y)) {
                columns.go_to(y * block_px);
                look_up(D(), columns);
            }
        found += columns.found();
    }
    return found;
}

/// Draws a tile. look_up(tag, pixels) finds what is seen at the pixels of a SeenGrid or of
/// DrawnColumns, and hands it to their put().
/// Returns how many pixels have depth.
template <bool searched, class LookUp>
int draw_tile(const MappedTile &tile, const LookUp &look_up, const DrawnTile &to) {
    const hn::CappedTag<float, most_pixels> d;
    Blocks blocks;
    if (tile.interpolated) {
        SeenGrid<hn::CappedTag<float, most_pixels>> seen(look_up.places());
        look_up(d, seen);
        const float parallax = std::abs(tile.parallax_u) + std::abs(tile.parallax_v);
        blocks.find<searched>(seen, alike_displacement_px / parallax);
        draw_between(seen.readings, to.millimetres);
        blocks.draw_edges(to.edge_distance);
    }
    if (blocks.all_even())
        return mapped_tile_px * mapped_tile_px;
    int found = 0;
    for (int x = 0; x < blocks_across; ++x) {
        int even = 0;
        for (int y = 0; y < blocks_across; ++y)
            even += static_cast<int>(blocks.even(x, y));
        found += even * block_px * block_px;
        if (even < blocks_across)
            found += draw_uneven(look_up, blocks, x, to);
    }
    return found;
}

} // namespace
} // namespace afterglow::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#endif
