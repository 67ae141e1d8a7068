// SPDX-License-Identifier: Apache-2.0
// Compiled once for each instruction set; the best of them is chosen when first called.
#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "core/warp/block_grid.cpp"
#include "core/warp/block_grid.hpp"

#include "core/warp/tile_nodes.hpp"
#include "core/warp/uneven_blocks.hpp"

#include <algorithm>
#include <cassert>
#include <cstdint>
#include <cstring>
#include <hwy/foreach_target.h>
#include <hwy/highway.h>
#include <limits>

// clang-format off: after Highway, once for each instruction set
#include "core/base/lanes-inl.hpp"
// clang-format on

namespace afterglow {
#if !defined(AFTERGLOW_CORE_KEYFRAME_BLOCK_GRID_CPP)
#define AFTERGLOW_CORE_KEYFRAME_BLOCK_GRID_CPP
/// Nodes of the blocks of a row of tiles, each with those at the right of the last block and below.
struct NodeRows {
    ImageView<const std::uint16_t> millimetres;
    ImageView<const std::uint8_t> edge_distance;
    ImageView<const std::int16_t> displacement;
};
/// What is drawn of them.
struct EvenRows {
    ImageView<std::uint8_t> even;
    ImageView<std::uint16_t> millimetres;
    ImageView<std::uint8_t> edge_distance;
    TileReadings *readings; ///< of each tile
};
/// Whether the blocks of a tile, from the x-th on, all have that value.
inline bool all_equal(std::uint8_t value, ImageView<const std::uint8_t> blocks, int x) {
    std::uint32_t differing = 0;
    for (int y = 0; y < mapped_tile_px / mapped_block_px; ++y) {
        std::uint32_t four;
        std::memcpy(&four, blocks.row(y) + x, sizeof four);
        differing |= four ^ value * std::uint32_t{0x01010101};
    }
    return differing == 0;
}
#endif
} // namespace afterglow

HWY_BEFORE_NAMESPACE();
namespace afterglow::HWY_NAMESPACE {
namespace {

constexpr int block_px = mapped_block_px, blocks_down = mapped_tile_px / block_px;
/// As many blocks at once, at most.
constexpr int most_blocks = 32;
/// Values of the pixel columns of some blocks, one line for each row of nodes.
using Lines = std::int16_t[blocks_down + 1][most_blocks * block_px];

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

/// Finds which blocks are even, from the x-th of each row on, and draws their edge distances; 0 in
/// other blocks. `even_columns`: a line for each row of blocks, -1 in the columns of even blocks,
/// else 0.
template <class D>
HWY_INLINE void find_even(D d, const NodeRows &nodes, const std::int16_t *most_displaced, int x,
                          const EvenRows &to, Lines &even_columns) {
    const hn::Rebind<std::uint8_t, D> d8;
    const auto limit = hn::LoadU(d, most_displaced + x);
    const auto least_edge = hn::Set(d, edge_free_block - 1);
    // Of both nodes at the left and right of a block's upper or lower side.
    struct Side {
        hn::Vec<D> least_edge, edges, nearest, farthest;
    };
    const auto side = [&](int y) HWY_ATTR {
        const auto edge_at = [&](int column) HWY_ATTR {
            return hn::PromoteTo(d, hn::LoadU(d8, nodes.edge_distance.row(y) + column));
        };
        const auto a = edge_at(x), b = edge_at(x + 1);
        const auto p = hn::LoadU(d, nodes.displacement.row(y) + x);
        const auto q = hn::LoadU(d, nodes.displacement.row(y) + x + 1);
        return Side{hn::Min(a, b), hn::Add(a, b), hn::Max(p, q), hn::Min(p, q)};
    };
    Side upper = side(0);
    for (int y = 0; y < blocks_down; ++y) {
        const Side lower = side(y + 1);
        const auto apart = hn::SaturatedSub(hn::Max(upper.nearest, lower.nearest),
                                            hn::Min(upper.farthest, lower.farthest));
        const auto is_even = hn::And(
            hn::Gt(hn::Min(upper.least_edge, lower.least_edge), least_edge), hn::Lt(apart, limit));
        const auto mean = hn::ShiftRight<2>(hn::Add(upper.edges, lower.edges));
        const auto even = hn::DemoteTo(d8, hn::IfThenElseZero(is_even, mean));
        hn::StoreU(even, d8, to.even.row(y) + x);
        for (int row = y * block_px; row < (y + 1) * block_px; ++row)
            hn::StoreInterleaved4(even, even, even, even, d8,
                                  to.edge_distance.row(row) + x * block_px);
        const auto mask = hn::VecFromMask(d, is_even);
        hn::StoreInterleaved4(mask, mask, mask, mask, d, even_columns[y]);
        upper = lower;
    }
}

/// Draws readings of even blocks, from the x-th of each row on, bilinearly between those of the
/// nodes; 0 in other blocks.
template <class D>
HWY_INLINE void draw_between(D d, ImageView<const std::uint16_t> nodes, int x,
                             const Lines &even_columns, ImageView<std::uint16_t> millimetres) {
    static_assert(block_px == 4);
    constexpr int blocks = static_cast<int>(hn::MaxLanes(D()));
    const hn::RebindToUnsigned<D> du;
    HWY_ALIGN Lines lines;
    for (int y = 0; y <= blocks_down; ++y) {
        const auto from = hn::BitCast(d, hn::LoadU(du, nodes.row(y) + x));
        const auto to = hn::BitCast(d, hn::LoadU(du, nodes.row(y) + x + 1));
        const auto [first, second, third] = quarters_between(from, to);
        hn::StoreInterleaved4(from, first, second, third, d, lines[y]);
    }
    for (int y = 0; y < blocks_down; ++y)
        for (int u = 0; u < blocks * block_px; u += blocks) {
            const auto from = hn::Load(d, lines[y] + u), to = hn::Load(d, lines[y + 1] + u);
            const auto even = hn::Load(d, even_columns[y] + u);
            const auto [first, second, third] = quarters_between(from, to);
            int row = y * block_px;
            for (const auto &reading : {from, first, second, third})
                hn::StoreU(hn::BitCast(du, hn::And(reading, even)), du,
                           millimetres.row(row++) + x * block_px + u);
        }
}

/// Of the tiles in a row, of which `even` tells the blocks.
void find_readings(ImageView<const std::uint16_t> nodes, ImageView<const std::uint8_t> even,
                   TileReadings *tiles) {
    const hn::CappedTag<std::uint16_t, blocks_down> d;
    constexpr int lanes = static_cast<int>(hn::MaxLanes(d));
    for (int first = 0; first < even.width(); first += blocks_down) {
        TileReadings &tile = *tiles++;
        tile = {};
        const std::uint8_t edge_distance = *(even.data() + first);
        if (edge_distance == 0 || !all_equal(edge_distance, even, first))
            continue;
        // Blocks are bilinear between their nodes.
        auto nearest = hn::Set(d, 0xffff), farthest = hn::Zero(d);
        for (int y = 0; y <= blocks_down; ++y)
            for (const int right : {0, 1})
                for (int i = 0; i < blocks_down; i += lanes) {
                    const auto of = hn::LoadU(d, nodes.row(y) + first + i + right);
                    nearest = hn::Min(nearest, of);
                    farthest = hn::Max(farthest, of);
                }
        tile = {.edge_distance = edge_distance,
                .nearest = hn::GetLane(hn::MinOfLanes(d, nearest)),
                .farthest = hn::GetLane(hn::MaxOfLanes(d, farthest))};
    }
}

void draw_even_blocks(const NodeRows &nodes, const std::int16_t *most_displaced,
                      const EvenRows &to) {
    for_overlapping_lanes(hn::CappedTag<std::int16_t, most_blocks>(), to.even.width(),
                          [&](auto d, int x) HWY_ATTR {
                              HWY_ALIGN Lines even_columns;
                              find_even(d, nodes, most_displaced, x, to, even_columns);
                              draw_between(d, nodes.millimetres, x, even_columns, to.millimetres);
                          });
    find_readings(nodes.millimetres, to.even, to.readings);
}

} // namespace
} // namespace afterglow::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace afterglow {
namespace {

HWY_EXPORT(draw_even_blocks);

/// How many values are 0, of four columns and at most 63 rows: looks at all four of a row at once.
int count_zeros(ImageView<const std::uint8_t> values) {
    constexpr std::uint32_t ones = 0x01010101;
    assert(values.width() == sizeof ones);
    std::uint32_t zeros = 0; // of each column
    for (int row = 0; row < values.height(); ++row) {
        std::uint32_t four;
        std::memcpy(&four, values.row(row), sizeof four);
        // The highest bit of each byte that is not 0, without carries from one byte to the next.
        const std::uint32_t there = ((four & 0x7f * ones) + 0x7f * ones) | four;
        zeros += ~there >> 7 & ones;
    }
    return static_cast<int>(zeros * ones >> 24);
}

} // namespace

BlockGrid::BlockGrid(int width, int height)
    : columns_(width / mapped_tile_px), rows_(height / mapped_tile_px),
      millimetres_(columns_ * blocks_across + 1, rows_ * blocks_across + 1),
      edge_distance_(millimetres_.width(), millimetres_.height()),
      displacement_(millimetres_.width(), millimetres_.height()),
      most_displaced_(columns_ * blocks_across, rows_),
      even_(columns_ * blocks_across, rows_ * blocks_across), readings_(columns_, rows_) {}

void BlockGrid::look_up(int x, int y, const MappedTile &tile, const ImageView<const float> &z,
                        int least_edge_distance) {
    // The last tiles have the nodes at the end of the view, too.
    const int across = blocks_across + static_cast<int>(x + 1 == columns_);
    const int down = blocks_across + static_cast<int>(y + 1 == rows_);
    const auto part = [&](auto image) {
        return part_of(image, x * blocks_across, y * blocks_across, across, down);
    };
    look_up_nodes(
        tile, z, least_edge_distance,
        {part(millimetres_.view()), part(edge_distance_.view()), part(displacement_.view())});
    std::int16_t most = -1;
    if (tile.interpolated)
        most = tile.searched ? static_cast<std::int16_t>(alike_displacement_px * displacement_units)
                             : std::numeric_limits<std::int16_t>::max();
    std::fill_n(most_displaced_.row(y) + x * blocks_across, blocks_across, most);
}

void BlockGrid::leave_out(int x, int y) {
    std::fill_n(most_displaced_.row(y) + x * blocks_across, blocks_across, std::int16_t{-1});
    for (int row = y * blocks_across; row < (y + 1) * blocks_across; ++row)
        std::fill_n(edge_distance_.row(row) + x * blocks_across, blocks_across, std::uint8_t{0});
}

void BlockGrid::draw_even(int y, ImageView<std::uint16_t> millimetres,
                          ImageView<std::uint8_t> edge_distance) {
    const auto nodes = [&](const auto &image) {
        return part_of(image.view(), 0, y * blocks_across, image.width(), blocks_across + 1);
    };
    const auto pixels = [&](auto image) {
        return part_of(image, 0, y * mapped_tile_px, columns_ * mapped_tile_px, mapped_tile_px);
    };
    HWY_DYNAMIC_DISPATCH(draw_even_blocks)
    ({nodes(millimetres_), nodes(edge_distance_), nodes(displacement_)}, most_displaced_.row(y),
     {part_of(even_.view(), 0, y * blocks_across, even_.width(), blocks_across),
      pixels(millimetres), pixels(edge_distance), readings_.row(y)});
}

int BlockGrid::draw_uneven(int x, int y, const MappedTile &tile, const ImageView<const float> &z,
                           int least_edge_distance, const ImageView<std::uint16_t> &millimetres,
                           const ImageView<std::uint8_t> &edge_distance) const {
    const auto even =
        part_of(even_.view(), x * blocks_across, y * blocks_across, blocks_across, blocks_across);
    const int uneven = count_zeros(even);
    const int drawn = (blocks_across * blocks_across - uneven) * mapped_block_px * mapped_block_px;
    if (uneven == 0)
        return drawn;
    const auto pixels = [&](auto image) {
        return part_of(image, x * mapped_tile_px, y * mapped_tile_px, mapped_tile_px,
                       mapped_tile_px);
    };
    return drawn + draw_uneven_blocks(tile, z, least_edge_distance, even, pixels(millimetres),
                                      pixels(edge_distance));
}

} // namespace afterglow
#endif
