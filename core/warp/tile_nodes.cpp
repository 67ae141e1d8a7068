// SPDX-License-Identifier: Apache-2.0
// Compiled once for each instruction set; the best of them is chosen when first called.
#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "core/warp/tile_nodes.cpp"
#include "core/warp/tile_nodes.hpp"

#include <algorithm>
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

/// The nodes: the first pixel of each block of a tile, row by row, then those of the blocks at its
/// right, of those below, and of the one below at the right.
constexpr int own_nodes = blocks_across * blocks_across;
constexpr int all_nodes = (blocks_across + 1) * (blocks_across + 1);
/// All of them, filled up to whole vectors.
constexpr int most_nodes = 32;

/// Column and row of a node, blocks.
struct Node {
    int x, y;
};
constexpr Node node(int i) {
    if (i < own_nodes)
        return {i % blocks_across, i / blocks_across};
    i -= own_nodes;
    if (i < blocks_across)
        return {blocks_across, i};
    return {i - blocks_across, blocks_across};
}
/// Columns and rows of the nodes, pixels of the tile.
struct NodePlaces {
    HWY_ALIGN float x[most_nodes], y[most_nodes];
};
constexpr NodePlaces node_places = [] {
    NodePlaces places{};
    for (int i = 0; i < all_nodes; ++i) {
        places.x[i] = static_cast<float>(node(i).x * block_px);
        places.y[i] = static_cast<float>(node(i).y * block_px);
    }
    return places;
}();

/// The nodes of a tile, and what is seen there.
class SeenNodes {
public:
    using D = hn::CappedTag<float, own_nodes>;
    static constexpr int lanes = static_cast<int>(hn::MaxLanes(D()));

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
        // Of a hole it may be any number: no block beside it is even.
        const auto displaced = truncated(di, hn::Mul(inverse_depth, hn::Set(d, displacement_)));
        hn::Store(reading, hn::Rebind<std::uint16_t, D>(), readings_ + i * lanes);
        hn::Store(hn::DemoteTo(d8, edge), d8, edges_ + i * lanes);
        hn::Store(hn::DemoteTo(d16, displaced), d16, displacements_ + i * lanes);
    }
    /// `beyond`: there are nodes for the blocks at the right or below, too.
    void copy_to(const BlockNodes &nodes, bool beyond) const {
        copy(readings_, nodes.millimetres, beyond);
        copy(edges_, nodes.edge_distance, beyond);
        copy(displacements_, nodes.displacement, beyond);
    }

private:
    template <class T>
    static void copy(const T *from, const ImageView<T> &to, bool beyond) {
        for (int y = 0; y < blocks_across; ++y)
            std::memcpy(to.row(y), from + y * blocks_across, blocks_across * sizeof(T));
        for (int i = own_nodes; beyond && i < all_nodes; ++i)
            if (const Node at = node(i); to.contains(at.x, at.y))
                to(at.x, at.y) = from[i];
    }

    TilePlaces places_;
    int vectors_;
    float displacement_;
    HWY_ALIGN std::uint16_t readings_[most_nodes];
    HWY_ALIGN std::uint8_t edges_[most_nodes];
    HWY_ALIGN std::int16_t displacements_[most_nodes];
};

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

/// Nodes of a tile of one surface: the nearest points, their depths moved along the slope between
/// the corners.
void see_surface(const MappedTile &tile, ImageView<const float> z, int least_edge_distance,
                 SeenNodes &nodes) {
    const SeenNodes::D d;
    const hn::RebindToSigned<SeenNodes::D> di;
    const TileSlope slope = slope_between(tile);
    for (int i = 0; i < nodes.vectors(); ++i) {
        const auto u = nodes.at(&TilePlaces::u, i), v = nodes.at(&TilePlaces::v, i);
        hn::Vec<decltype(di)> x, y;
        const auto point = point_near(d, z, u, v, x, y);
        const auto moved_by =
            hn::Add(hn::Mul(hn::Set(d, slope.by_u), hn::Sub(u, hn::ConvertTo(d, x))),
                    hn::Mul(hn::Set(d, slope.by_v), hn::Sub(v, hn::ConvertTo(d, y))));
        const auto edge = edge_of(d, point);
        const auto there = hn::Gt(edge, hn::Set(di, least_edge_distance - 1));
        nodes.put(i,
                  reading_of(d, hn::Add(point, moved_by), nodes.at(&TilePlaces::scale, i),
                             nodes.at(&TilePlaces::shift, i), there),
                  hn::IfThenElseZero(there, edge), hn::Div(hn::Set(d, 1.0f), point));
    }
}

/// What is seen at places of a tile that is not of one surface: the nearest point; the depth,
/// metres, at the place itself; and how far the point's parallax moves it from the place, columns
/// and rows.
template <class V>
struct SeenPoint {
    V point, depth, moved_u, moved_v;
};
/// A place among four neighbours: how far it is from the first one, columns and rows, and the
/// inverse depth, 1/m, of points that are seen there.
template <class V>
struct Place {
    V right, down, inverse_depth;
};
template <class V>
HWY_API auto is_second(V way) {
    const hn::DFromV<V> d;
    return hn::Not(hn::Lt(order(d, way), order(d, hn::Set(d, 0.5f))));
}
template <class V>
HWY_API SeenPoint<V> moved_to(const Place<V> &place, V point, const Parallax<V> &parallax) {
    const hn::DFromV<V> d;
    const auto excess = hn::Sub(hn::Div(hn::Set(d, 1.0f), point), place.inverse_depth);
    return {point, point, hn::Mul(parallax.u, excess), hn::Mul(parallax.v, excess)};
}
/// With the depth that is bilinear between the four points around the place, moved by the nearest
/// one's parallax, unless one of them is missing or that point is beside an edge: they may be of
/// another surface.
template <class D, class V>
HWY_API SeenPoint<V> surface_seen_at(D d, ImageView<const float> z, const std::int32_t *places,
                                     const Place<V> &place, const Parallax<V> &parallax) {
    const hn::RebindToSigned<D> di;
    const hn::RebindToUnsigned<D> du;
    const auto [a, b, c, e] = neighbours_at(d, z.data(), z.stride(), places); // metres, 0 = none
    const auto is_right = hn::RebindMask(d, is_second(place.right));
    const auto is_below = hn::RebindMask(d, is_second(place.down));
    const auto point =
        hn::IfThenElse(is_below, hn::IfThenElse(is_right, e, c), hn::IfThenElse(is_right, b, a));
    const auto bits = [&](V value) HWY_ATTR { return hn::BitCast(du, value); };
    const auto least = hn::Min(hn::Min(bits(a), bits(b)), hn::Min(bits(c), bits(e)));
    const auto inside = hn::And(hn::Gt(edge_of(d, point), hn::Set(di, beside_edge)),
                                hn::RebindMask(di, hn::Ne(least, hn::Zero(du))));
    SeenPoint<V> seen = moved_to(place, point, parallax);
    const auto x = hn::Sub(place.right, seen.moved_u), y = hn::Sub(place.down, seen.moved_v);
    const auto across = hn::Sub(b, a);
    const auto above = hn::Add(a, hn::Mul(x, across));
    const auto step = hn::Add(hn::Sub(c, a), hn::Mul(x, hn::Sub(hn::Sub(e, c), across)));
    const auto between = hn::Add(above, hn::Mul(y, step));
    const auto most = hn::Mul(hn::Set(d, 1 + steepest), point);
    const auto limited = hn::Max(hn::Min(between, most), hn::Mul(hn::Set(d, 1 - steepest), point));
    seen.depth = hn::IfThenElse(hn::RebindMask(d, inside), limited, point);
    return seen;
}

/// Nodes of other tiles. If points are searched for, from the nearest depth on, the place is moved
/// by the parallax of what is there: so of several points that are seen at a pixel the nearest is
/// found, unless it is narrower than the way to it.
template <bool searched>
class ParallaxNodes {
public:
    ParallaxNodes(const MappedTile &tile, ImageView<const float> z) : tile_(tile), z_(z) {}

    /// In two passes: the registers of small targets do not hold what both need.
    void see(int least_edge_distance, SeenNodes &nodes) {
        find(nodes);
        look_up(least_edge_distance, nodes);
    }

private:
    using D = SeenNodes::D;
    static constexpr int lanes = SeenNodes::lanes;

    void find(const SeenNodes &nodes) {
        const D d;
        const hn::RebindToSigned<D> di;
        const auto first_of_two = [&](auto place, int size) HWY_ATTR {
            const auto last = hn::Set(d, static_cast<float>(size - 2));
            return truncated(di, hn::Min(hn::Max(place, hn::Zero(d)), last));
        };
        for (int i = 0; i < nodes.vectors(); ++i) {
            auto u = nodes.at(&TilePlaces::u, i), v = nodes.at(&TilePlaces::v, i);
            const auto inverse_depth = move_by_parallax<searched>(d, tile_, z_, u, v);
            hn::Store(inverse_depth, d, inverse_depth_ + i * lanes);
            const auto x = first_of_two(u, z_.width()), y = first_of_two(v, z_.height());
            hn::Store(hn::Add(hn::Mul(y, hn::Set(di, z_.stride())), x), di, first_ + i * lanes);
            hn::Store(hn::Sub(u, hn::ConvertTo(d, x)), d, right_ + i * lanes);
            hn::Store(hn::Sub(v, hn::ConvertTo(d, y)), d, down_ + i * lanes);
        }
    }

    void look_up(int least_edge_distance, SeenNodes &nodes) const {
        const D d;
        const hn::RebindToSigned<D> di;
        const hn::RebindToUnsigned<D> du;
        const auto parallax = parallax_of(d, tile_);
        const auto half = hn::Set(d, 0.5f);
        // As unsigned numbers the bits of negative floats, and of NaN, are beyond all others.
        const auto below = [&](auto value, float limit) HWY_ATTR {
            return hn::RebindMask(
                di, hn::Lt(hn::BitCast(du, value), hn::BitCast(du, hn::Set(d, limit))));
        };
        for (int i = 0; i < nodes.vectors(); ++i) {
            const Place<hn::Vec<D>> place = {hn::Load(d, right_ + i * lanes),
                                             hn::Load(d, down_ + i * lanes),
                                             hn::Load(d, inverse_depth_ + i * lanes)};
            const auto seen = surface_seen_at(d, z_, first_ + i * lanes, place, parallax);
            const auto edge = edge_of(d, seen.point);
            auto there = hn::And(hn::Gt(edge, hn::Set(di, least_edge_distance - 1)),
                                 hn::And(below(hn::Add(place.right, half), 2.0f),
                                         below(hn::Add(place.down, half), 2.0f)));
            if constexpr (searched) {
                const auto moved = hn::Add(hn::Abs(seen.moved_u), hn::Abs(seen.moved_v));
                there = hn::And(there, below(moved, most_missed_px));
            }
            nodes.put(i,
                      reading_of(d, seen.depth, nodes.at(&TilePlaces::scale, i),
                                 nodes.at(&TilePlaces::shift, i), there),
                      hn::IfThenElseZero(there, edge), place.inverse_depth);
        }
    }

    const MappedTile &tile_;
    ImageView<const float> z_;
    /// Of each node: where the surface's depths have the first of four neighbours, how far the
    /// place is from that one, columns and rows, and the inverse depth, 1/m, of points that are
    /// seen there.
    HWY_ALIGN std::int32_t first_[most_nodes];
    HWY_ALIGN float right_[most_nodes], down_[most_nodes], inverse_depth_[most_nodes];
};

void look_up(const MappedTile &tile, const ImageView<const float> &z, int least_edge_distance,
             const BlockNodes &to) {
    const bool beyond =
        to.millimetres.width() > blocks_across || to.millimetres.height() > blocks_across;
    SeenNodes nodes(TilePlaces(tile), beyond ? all_nodes : own_nodes, tile.parallax_px());
    if (tile.one_surface)
        see_surface(tile, z, least_edge_distance, nodes);
    else if (tile.searched)
        ParallaxNodes<true>(tile, z).see(least_edge_distance, nodes);
    else
        ParallaxNodes<false>(tile, z).see(least_edge_distance, nodes);
    nodes.copy_to(to, beyond);
}

} // namespace
} // namespace afterglow::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace afterglow {
namespace {

HWY_EXPORT(look_up);

} // namespace

void look_up_nodes(const MappedTile &tile, const ImageView<const float> &z, int least_edge_distance,
                   const BlockNodes &nodes) {
    HWY_DYNAMIC_DISPATCH(look_up)(tile, z, least_edge_distance, nodes);
}

} // namespace afterglow
#endif
