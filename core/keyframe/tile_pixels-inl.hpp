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

/// The nodes: the first pixel of each block of a tile, row by row, then those of the blocks at its
/// right, below, and below at its right.
inline constexpr int block_px = mapped_block_px, blocks_across = mapped_tile_px / block_px;
inline constexpr int own_nodes = blocks_across * blocks_across;
inline constexpr int all_nodes = (blocks_across + 1) * (blocks_across + 1);
/// So many pixels at once, at most: all nodes, filled up to whole vectors.
inline constexpr int most_pixels = 32;

struct Pixel {
    int x, y;
};
constexpr Pixel node(int i) {
    if (i < own_nodes)
        return {i % blocks_across, i / blocks_across};
    i -= own_nodes;
    if (i < blocks_across)
        return {blocks_across, i};
    return {i - blocks_across, blocks_across};
}
/// Columns and rows of the pixels of a tile.
struct PixelPlaces {
    HWY_ALIGN float x[most_pixels], y[most_pixels];
};
template <class At>
constexpr PixelPlaces places_of(int count, int step, At at) {
    PixelPlaces places{};
    for (int i = 0; i < count; ++i) {
        places.x[i] = static_cast<float>(at(i).x * step);
        places.y[i] = static_cast<float>(at(i).y * step);
    }
    return places;
}
inline constexpr PixelPlaces node_places = places_of(all_nodes, block_px, node);
inline constexpr PixelPlaces block_places = places_of(block_px * block_px, 1, [](int i) {
    return Pixel{i % block_px, i / block_px};
});

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

/// The nodes of a tile, and what is seen there.
template <class D>
class SeenNodes {
public:
    static constexpr int lanes = static_cast<int>(hn::MaxLanes(D()));
    static constexpr bool between_points = true;

    /// `parallax_px`: by how much a point is displaced whose inverse depth is 1 / m.
    SeenNodes(const TilePlaces &places, int count, float parallax_px)
        : places_(places), vectors_((count - 1) / lanes + 1),
          displacement_(displacement_units * parallax_px) {}

    int vectors() const { return vectors_; }
    /// Values at the i-th vector of pixels.
    HWY_INLINE auto at(BetweenCorners TilePlaces::*of, int i) const {
        const D d;
        const BetweenCorners &value = places_.*of;
        const auto x = hn::Load(d, node_places.x + i * lanes);
        const auto y = hn::Load(d, node_places.y + i * lanes);
        const auto step = hn::Add(hn::Set(d, value.down), hn::Mul(x, hn::Set(d, value.twist)));
        return hn::Add(hn::Add(hn::Set(d, value.at), hn::Mul(x, hn::Set(d, value.across))),
                       hn::Mul(y, step));
    }
    template <class V16, class VI, class V>
    HWY_INLINE void put(int i, V16 reading, VI edge, V inverse_depth) {
        const D d;
        const hn::RebindToSigned<D> di;
        const hn::Rebind<std::uint8_t, D> d8;
        const hn::Rebind<std::int16_t, D> d16;
        const auto displaced = hn::ConvertTo(di, hn::Mul(inverse_depth, hn::Set(d, displacement_)));
        hn::Store(reading, hn::Rebind<std::uint16_t, D>(), readings_ + i * lanes);
        hn::Store(hn::DemoteTo(d8, edge), d8, edges_ + i * lanes);
        hn::Store(hn::DemoteTo(d16, displaced), d16, displacements_ + i * lanes);
    }
    void copy_to(const BlockNodes &nodes) const {
        copy(readings_, nodes.millimetres);
        copy(edges_, nodes.edge_distance);
        copy(displacements_, nodes.displacement);
    }

private:
    template <class T>
    static void copy(const T *from, const ImageView<T> &to) {
        for (int y = 0; y < blocks_across; ++y)
            std::memcpy(to.row(y), from + y * blocks_across, blocks_across * sizeof(T));
        for (int i = own_nodes; i < all_nodes; ++i)
            if (const Pixel at = node(i); to.contains(at.x, at.y))
                to(at.x, at.y) = from[i];
    }

    const TilePlaces &places_;
    int vectors_;
    float displacement_;
    HWY_ALIGN std::uint16_t readings_[most_pixels];
    HWY_ALIGN std::uint8_t edges_[most_pixels];
    HWY_ALIGN std::int16_t displacements_[most_pixels];
};

/// Draws pixels of a tile in columns: as many as a block has, or as a vector has lanes if that is
/// fewer. One vector holds pixels of one or several rows.
template <class D>
class DrawnColumns {
public:
    static constexpr int lanes = static_cast<int>(hn::MaxLanes(D()));
    static constexpr int columns = std::min(lanes, block_px), rows = lanes / columns;
    static constexpr bool between_points = false;

    DrawnColumns(const TilePlaces &places, int first, const DrawnTile &to)
        : u_(places.u, first), v_(places.v, first), scale_(places.scale, first),
          shift_(places.shift, first), to_(to), first_(first),
          found_(hn::Zero(hn::RebindToSigned<D>())) {}

    static constexpr int vectors() { return block_px / rows; }
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
                hn::Add(hn::Load(d, block_places.x), hn::Set(d, static_cast<float>(first)));
            step = hn::Add(hn::Set(d, value.down), hn::Mul(column, hn::Set(d, value.twist)));
            top = hn::Add(hn::Set(d, value.at), hn::Mul(column, hn::Set(d, value.across)));
            if constexpr (rows > 1)
                top = hn::Add(top, hn::Mul(hn::Load(d, block_places.y), step));
        }
    };
    Value u_, v_, scale_, shift_;
    DrawnTile to_;
    int first_, row_ = 0;
    hn::Vec<hn::RebindToSigned<D>> found_;
};

/// Looks up the nodes of a tile. look_up(tag, pixels) finds what is seen at the pixels of SeenNodes
/// or of DrawnColumns, and hands it to their put().
template <class LookUp>
void see_nodes(const MappedTile &tile, const LookUp &look_up, const BlockNodes &nodes) {
    using D = hn::CappedTag<float, own_nodes>;
    const bool beyond =
        nodes.millimetres.width() > blocks_across || nodes.millimetres.height() > blocks_across;
    SeenNodes<D> seen(look_up.places(), beyond ? all_nodes : own_nodes, tile.parallax_px());
    look_up(D(), seen);
    seen.copy_to(nodes);
}

/// Draws the blocks of a column that are not even; returns how many pixels have depth.
template <class LookUp>
HWY_NOINLINE int draw_uneven(const LookUp &look_up, ImageView<const std::uint8_t> even, int x,
                             const DrawnTile &to) {
    using D = hn::CappedTag<float, block_px * block_px>;
    int found = 0;
    for (int column = x * block_px; column < (x + 1) * block_px;
         column += DrawnColumns<D>::columns) {
        DrawnColumns<D> columns(look_up.places(), column, to);
        for (int y = 0; y < blocks_across; ++y)
            if (even(x, y) == 0) {
                columns.go_to(y * block_px);
                look_up(D(), columns);
            }
        found += columns.found();
    }
    return found;
}

/// Draws the blocks of a tile that are not even; returns how many pixels have depth.
template <class LookUp>
int draw_uneven_columns(const LookUp &look_up, ImageView<const std::uint8_t> even,
                        const DrawnTile &to) {
    int found = 0;
    for (int x = 0; x < blocks_across; ++x)
        if (even(x, 0) == 0 || even(x, 1) == 0 || even(x, 2) == 0 || even(x, 3) == 0)
            found += draw_uneven(look_up, even, x, to);
    return found;
}

} // namespace
} // namespace afterglow::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#endif
