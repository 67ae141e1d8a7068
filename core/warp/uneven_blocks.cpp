// SPDX-License-Identifier: Apache-2.0
// Compiled once for each instruction set; the best of them is chosen when first called.
#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "core/warp/uneven_blocks.cpp"
#include "core/warp/uneven_blocks.hpp"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <cstring>
#include <hwy/foreach_target.h>
#include <hwy/highway.h>

// clang-format off: after Highway, once for each instruction set
#include "core/base/lanes-inl.hpp"
#include "core/surface/surface_point-inl.hpp"
#include "core/warp/tile_places-inl.hpp"
// clang-format on

HWY_BEFORE_NAMESPACE();
namespace afterglow::HWY_NAMESPACE {
namespace {

/// Where a tile is drawn.
struct DrawnTile {
    ImageView<std::uint16_t> millimetres;
    ImageView<std::uint8_t> edge_distance;
};

/// Columns and rows of a block's pixels, row by row.
constexpr struct {
    HWY_ALIGN float x[16] = {0, 1, 2, 3, 0, 1, 2, 3, 0, 1, 2, 3, 0, 1, 2, 3};
    HWY_ALIGN float y[16] = {0, 0, 0, 0, 1, 1, 1, 1, 2, 2, 2, 2, 3, 3, 3, 3};
} columns_and_rows;
static_assert(block_px == 4);

/// A value at some columns of a tile's first row, and the step to the next row.
template <class V>
struct InColumns {
    V top, step;

    InColumns(const BetweenCorners &value, V columns) {
        const hn::DFromV<V> d;
        step = hn::Add(hn::Set(d, value.down), hn::Mul(columns, hn::Set(d, value.twist)));
        top = hn::Add(hn::Set(d, value.at), hn::Mul(columns, hn::Set(d, value.across)));
    }
    HWY_INLINE V in_row(V row) const { return hn::Add(top, hn::Mul(row, step)); }
    HWY_INLINE V in_row(int row) const {
        return in_row(hn::Set(hn::DFromV<V>(), static_cast<float>(row)));
    }
};

/// Draws pixels of a tile in columns: as many as a block has, or as a vector has lanes if that is
/// fewer. One vector holds pixels of one or several rows.
template <class D>
class DrawnColumns {
public:
    static constexpr int lanes = static_cast<int>(hn::MaxLanes(D()));
    static constexpr int columns = std::min(lanes, block_px), rows = lanes / columns;

    DrawnColumns(const TilePlaces &places, int first, const DrawnTile &to)
        : u_(value(places.u, first)), v_(value(places.v, first)),
          scale_(value(places.scale, first)), shift_(value(places.shift, first)), to_(to),
          first_(first), found_(hn::Zero(hn::RebindToSigned<D>())) {}

    static constexpr int vectors() { return block_px / rows; }
    /// at() and put() are about the block whose first row is this row of the tile.
    void go_to(int row) { row_ = row; }
    HWY_INLINE auto at(BetweenCorners TilePlaces::*of, int i) const {
        const Value &value = of == &TilePlaces::u       ? u_
                             : of == &TilePlaces::v     ? v_
                             : of == &TilePlaces::scale ? scale_
                                                        : shift_;
        return value.in_row(row_ + i * rows);
    }
    template <class V16, class VI>
    HWY_INLINE void put(int i, V16 reading, VI edge) {
        const hn::RebindToSigned<D> di;
        found_ = hn::Sub(found_, hn::VecFromMask(di, hn::Gt(edge, hn::Zero(di))));
        store(reading, hn::DemoteTo(hn::Rebind<std::uint8_t, D>(), edge), row_ + i * rows);
    }
    int found() const { return hn::GetLane(hn::SumOfLanes(hn::RebindToSigned<D>(), found_)); }

private:
    /// At the lanes of a vector that begins on the tile's first row.
    using Value = InColumns<hn::Vec<D>>;
    static Value value(const BetweenCorners &of, int first) {
        const D d;
        Value value(
            of, hn::Add(hn::Load(d, columns_and_rows.x), hn::Set(d, static_cast<float>(first))));
        if constexpr (rows > 1)
            value.top = value.in_row(hn::Load(d, columns_and_rows.y));
        return value;
    }
    template <class V16, class V8>
    HWY_INLINE void store(V16 readings, V8 edges, int row) const {
        const hn::Rebind<std::uint16_t, D> d16;
        const hn::Rebind<std::uint8_t, D> d8;
        if constexpr (rows == 1) {
            hn::StoreU(readings, d16, to_.millimetres.row(row) + first_);
            hn::StoreU(edges, d8, to_.edge_distance.row(row) + first_);
        } else {
            HWY_ALIGN std::uint16_t readings_of_rows[rows][columns];
            HWY_ALIGN std::uint8_t edges_of_rows[rows][columns];
            hn::Store(readings, d16, readings_of_rows[0]);
            hn::Store(edges, d8, edges_of_rows[0]);
            for (int k = 0; k < rows; ++k) {
                std::memcpy(to_.millimetres.row(row + k) + first_, readings_of_rows[k],
                            sizeof readings_of_rows[k]);
                std::memcpy(to_.edge_distance.row(row + k) + first_, edges_of_rows[k],
                            sizeof edges_of_rows[k]);
            }
        }
    }

    Value u_, v_, scale_, shift_;
    DrawnTile to_;
    int first_, row_ = 0;
    hn::Vec<hn::RebindToSigned<D>> found_;
};

/// Looks up the pixels of a block, each for itself.
template <bool searched, class D>
HWY_INLINE void look_up(D d, const MappedTile &tile, ImageView<const float> z,
                        int least_edge_distance, DrawnColumns<D> &pixels) {
    const hn::RebindToSigned<D> di;
    for (int i = 0; i < pixels.vectors(); ++i) {
        auto u = pixels.at(&TilePlaces::u, i), v = pixels.at(&TilePlaces::v, i);
        const auto inverse_depth = move_by_parallax<searched>(d, tile, z, u, v);
        hn::Vec<decltype(di)> x, y;
        const auto point = point_near(d, z, u, v, x, y);
        const auto edge = edge_of(d, point);
        auto there = hn::Gt(edge, hn::Set(di, least_edge_distance - 1));
        if constexpr (searched) {
            // |1 / point - inverse_depth| parallax < most_missed_px
            const auto off = hn::Abs(hn::Sub(hn::Set(d, 1.0f), hn::Mul(inverse_depth, point)));
            const auto least = hn::Mul(off, hn::Set(d, tile.parallax_px() / most_missed_px));
            there = hn::And(there, hn::RebindMask(di, hn::Lt(order(d, least), order(d, point))));
        }
        pixels.put(i,
                   reading_of(d, point, pixels.at(&TilePlaces::scale, i),
                              pixels.at(&TilePlaces::shift, i), there),
                   hn::IfThenElseZero(there, edge));
    }
}

/// Bit y is 1 where row y has an uneven block among `blocks` blocks, from column x on.
template <int blocks>
int uneven_rows(ImageView<const std::uint8_t> even, int x) {
    int rows = 0;
    for (int y = 0; y < blocks_across; ++y) {
        const std::uint8_t *const row = even.row(y) + x;
        rows |= static_cast<int>(std::count(row, row + blocks, 0) > 0) << y;
    }
    return rows;
}

/// Draws the uneven blocks of column x, those of uneven_rows<1>(); returns how many pixels have
/// depth.
template <bool searched>
HWY_NOINLINE int draw_column(const MappedTile &tile, const TilePlaces &places,
                             ImageView<const float> z, int least_edge_distance, int uneven, int x,
                             const DrawnTile &to) {
    const hn::CappedTag<float, block_px * block_px> d;
    using Columns = DrawnColumns<decltype(hn::CappedTag<float, block_px * block_px>())>;
    int found = 0;
    for (int column = x * block_px; column < (x + 1) * block_px; column += Columns::columns) {
        Columns pixels(places, column, to);
        for (int y = 0; y < blocks_across; ++y)
            if ((uneven >> y & 1) != 0) {
                pixels.go_to(y * block_px);
                look_up<searched>(d, tile, z, least_edge_distance, pixels);
            }
        found += pixels.found();
    }
    return found;
}

template <bool searched>
int draw_columns(const MappedTile &tile, ImageView<const float> z, int least_edge_distance,
                 ImageView<const std::uint8_t> even, const DrawnTile &to) {
    const TilePlaces places(tile);
    int found = 0;
    for (int x = 0; x < blocks_across; ++x)
        if (const int uneven = uneven_rows<1>(even, x); uneven != 0)
            found += draw_column<searched>(tile, places, z, least_edge_distance, uneven, x, to);
    return found;
}

/// Whether a tile is hardly turned or scaled against the surface, and not at its border: then the
/// points of four pixels of a row are four of a row.
bool shows_rows(const MappedTile &tile, ImageView<const float> z) {
    // No point is half a pixel farther from its place than the nearest one.
    constexpr float most_deformed = 1.0f / (block_px - 1), border_px = 3;
    const MappedCorner *const corners = tile.corners;
    for (int i = 0; i < 4; i += 2) {
        const float u = corners[i + 1].u - corners[i].u, v = corners[i + 1].v - corners[i].v;
        if (!(std::abs(u - mapped_tile_px) < most_deformed * mapped_tile_px &&
              std::abs(v) < most_deformed * mapped_tile_px))
            return false;
    }
    return std::all_of(corners, corners + 4, [&](const MappedCorner &corner) {
        return corner.u > border_px && corner.u < static_cast<float>(z.width() - 1) - border_px &&
               corner.v > border_px && corner.v < static_cast<float>(z.height() - 1) - border_px;
    });
}

/// Where the points of a block's pixels begin, by row of the tile, from the place of the row's
/// middle.
struct RowPlaces {
    HWY_ALIGN std::int32_t first[mapped_tile_px];

    void find(const TilePlaces &places, int x, int stride) {
        const hn::CappedTag<float, mapped_tile_px> d;
        const hn::RebindToSigned<decltype(hn::CappedTag<float, mapped_tile_px>())> di;
        const float middle = static_cast<float>(x * block_px) + 0.5f * (block_px - 1);
        for (int row = 0; row < mapped_tile_px; row += static_cast<int>(hn::MaxLanes(d))) {
            const auto y = hn::Load(d, whole_numbers.data() + row);
            const auto at = [&](const BetweenCorners &value) HWY_ATTR {
                return hn::Add(hn::Set(d, value.at + middle * value.across),
                               hn::Mul(y, hn::Set(d, value.down + middle * value.twist)));
            };
            const auto u = truncated(di, hn::Sub(at(places.u), hn::Set(d, 1)));
            const auto v = truncated(di, hn::Add(at(places.v), hn::Set(d, 0.5f)));
            hn::Store(hn::Add(hn::Mul(v, hn::Set(di, stride)), u), di, first + row);
        }
    }
};

/// Loads the points of a row of several blocks, each from its own place.
template <class D>
HWY_INLINE hn::Vec<D> load_row(D d, const float *points, const RowPlaces *blocks, int row) {
#if HWY_TARGET != HWY_SCALAR // which has no vectors to combine
    constexpr int lanes = static_cast<int>(hn::MaxLanes(D()));
    if constexpr (lanes > block_px) {
        const hn::Half<D> half;
        return hn::Combine(d, load_row(half, points, blocks + lanes / block_px / 2, row),
                           load_row(half, points, blocks, row));
    }
#endif
    return hn::LoadU(d, points + blocks->first[row]);
}

/// Draws the uneven blocks of such a tile. The points of the four pixels of a row are taken to be
/// beside each other, so that they are loaded at once, and have their own depths. Even blocks
/// between uneven ones keep what is drawn there.
int draw_rows(const MappedTile &tile, ImageView<const float> z, int least_edge_distance,
              ImageView<const std::uint8_t> even, const DrawnTile &to) {
    const hn::CappedTag<float, mapped_tile_px> d;
    using D = decltype(hn::CappedTag<float, mapped_tile_px>());
    const hn::RebindToSigned<D> di;
    const hn::Rebind<std::uint16_t, D> d16;
    const hn::Rebind<std::uint8_t, D> d8;
    constexpr int lanes = static_cast<int>(hn::MaxLanes(D()));
    constexpr int blocks = std::max(lanes / block_px, 1); // beside each other, at once
    const TilePlaces places(tile);
    const auto least_edge = hn::Set(di, least_edge_distance - 1);
    auto found = hn::Zero(di);
    RowPlaces first[blocks];
    for (int x = 0; x < blocks_across; x += blocks) {
        const int uneven = uneven_rows<blocks>(even, x);
        if (uneven == 0)
            continue;
        for (int i = 0; i < blocks; ++i)
            first[i].find(places, x + i, z.stride());
        for (int left = x * block_px; left < (x + blocks) * block_px; left += lanes) {
            const auto columns = ramp(d, left);
            const InColumns scale(places.scale, columns), shift(places.shift, columns);
            for (int y = 0; y < blocks_across; ++y) {
                if ((uneven >> y & 1) == 0)
                    continue;
                const int first_row = y * block_px, end_row = first_row + block_px;
                std::uint16_t *millimetres = to.millimetres.row(first_row) + left;
                std::uint8_t *edges = to.edge_distance.row(first_row) + left;
                for (int row = first_row; row < end_row; ++row) {
                    const auto point = load_row(d, z.data() + left % block_px, first, row);
                    const auto edge = edge_of(d, point);
                    auto there = hn::Gt(edge, least_edge);
                    if constexpr (blocks > 1) // even blocks, which have edge distances, stay
                        there = hn::And(
                            there, hn::Eq(hn::PromoteTo(di, hn::LoadU(d8, edges)), hn::Zero(di)));
                    auto reading =
                        reading_of(d, point, scale.in_row(row), shift.in_row(row), there);
                    auto distance = hn::DemoteTo(d8, hn::IfThenElseZero(there, edge));
                    if constexpr (blocks > 1) {
                        reading = hn::Or(reading, hn::LoadU(d16, millimetres));
                        distance = hn::Or(distance, hn::LoadU(d8, edges));
                    }
                    hn::StoreU(reading, d16, millimetres);
                    hn::StoreU(distance, d8, edges);
                    millimetres += to.millimetres.stride();
                    edges += to.edge_distance.stride();
                    found = hn::Sub(found, hn::VecFromMask(di, there));
                }
            }
        }
    }
    return hn::GetLane(hn::SumOfLanes(di, found));
}

int draw(const MappedTile &tile, const ImageView<const float> &z, int least_edge_distance,
         const ImageView<const std::uint8_t> &even, const ImageView<std::uint16_t> &millimetres,
         const ImageView<std::uint8_t> &edge_distance) {
    const DrawnTile to = {millimetres, edge_distance};
    if (tile.searched)
        return draw_columns<true>(tile, z, least_edge_distance, even, to);
    if (shows_rows(tile, z))
        return draw_rows(tile, z, least_edge_distance, even, to);
    return draw_columns<false>(tile, z, least_edge_distance, even, to);
}

} // namespace
} // namespace afterglow::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace afterglow {
namespace {

HWY_EXPORT(draw);

} // namespace

int draw_uneven_blocks(const MappedTile &tile, const ImageView<const float> &z,
                       int least_edge_distance, const ImageView<const std::uint8_t> &even,
                       const ImageView<std::uint16_t> &millimetres,
                       const ImageView<std::uint8_t> &edge_distance) {
    return HWY_DYNAMIC_DISPATCH(draw)(tile, z, least_edge_distance, even, millimetres,
                                      edge_distance);
}

} // namespace afterglow
#endif
