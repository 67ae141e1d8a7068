// SPDX-License-Identifier: Apache-2.0
// Compiled once for each instruction set; the best of them is chosen when first called.
#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "core/keyframe/parallax_tile.cpp"
#include "core/keyframe/parallax_tile.hpp"

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

/// A point that was searched for is not seen at its place if its own parallax puts it farther from
/// there, pixels.
constexpr float most_missed_px = 3.0f;

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

/// The inverse depths, 1/m, of the nearest points to some places; `missing` where there is none.
template <class D, class V>
HWY_API V inverse_depth_near(D d, ImageView<const float> z, V u, V v, float missing) {
    const hn::RebindToSigned<D> di;
    const auto nearest = [&](V place, int size) HWY_ATTR {
        const auto at = hn::ConvertTo(di, hn::Add(place, hn::Set(d, 0.5f)));
        return hn::Min(hn::Max(at, hn::Zero(di)), hn::Set(di, size - 1));
    };
    const auto x = nearest(u, z.width()), y = nearest(v, z.height());
    const auto point = gather(d, z.data(), hn::Add(hn::Mul(y, hn::Set(di, z.stride())), x));
    const auto hole = hn::RebindMask(d, hn::Eq(hn::BitCast(di, point), hn::Zero(di)));
    return hn::IfThenElse(hole, hn::Set(d, missing), hn::Div(hn::Set(d, 1.0f), point));
}

/// Looks up the points at the places that the corners tell if all are displaced alike; else those
/// that are found from the nearest depth on, the place being moved by the parallax of what is
/// there. So of several points that are seen on one pixel the nearest is found, unless it is
/// narrower than the way to it.
template <bool searched>
class ParallaxPoints {
public:
    ParallaxPoints(const MappedTile &tile, ImageView<const float> z, int least_edge_distance)
        : tile_(tile), places_(tile), z_(z), least_edge_distance_(least_edge_distance) {}

    const TilePlaces &places() const { return places_; }
    template <class D, class Pixels>
    HWY_INLINE void operator()(D d, Pixels &pixels) const {
        if constexpr (Pixels::between_points) {
            // In two passes: the registers of small targets do not hold what both need.
            Neighbourhoods at;
            find(d, pixels, at);
            see_surface(d, at, pixels);
        } else {
            see_points(d, pixels);
        }
    }

private:
    /// Where the surface's depths have the first of four neighbours, how far a place is from that
    /// one, columns and rows, and the inverse depth, 1/m, of points that are seen there.
    struct Neighbourhoods {
        HWY_ALIGN std::int32_t first[most_pixels];
        HWY_ALIGN float right[most_pixels], down[most_pixels], inverse_depth[most_pixels];
    };

    /// Moves places by the parallax of what is there, if points are searched for. Returns the
    /// inverse depths of points that are seen there, 1/m.
    template <class D, class V>
    HWY_INLINE V move_by_parallax(D d, const Parallax<V> &parallax, V &u, V &v) const {
        if constexpr (!searched)
            return parallax.inverse_depth;
        const auto inverse_depth = inverse_depth_near(d, z_, u, v, tile_.farthest_inverse_depth);
        const auto excess = hn::Sub(inverse_depth, parallax.inverse_depth);
        u = hn::Sub(u, hn::Mul(parallax.u, excess));
        v = hn::Sub(v, hn::Mul(parallax.v, excess));
        return inverse_depth;
    }

    template <class D, class Pixels>
    HWY_INLINE void find(D d, const Pixels &pixels, Neighbourhoods &found) const {
        const hn::RebindToSigned<D> di;
        constexpr int lanes = static_cast<int>(hn::MaxLanes(D()));
        const auto parallax = parallax_of(d, tile_);
        const auto first_of_two = [&](auto place, int size) HWY_ATTR {
            const auto at = hn::ConvertTo(di, place);
            return hn::Min(hn::Max(at, hn::Zero(di)), hn::Set(di, size - 2));
        };
        for (int i = 0; i < pixels.vectors(); ++i) {
            auto u = pixels.at(&TilePlaces::u, i), v = pixels.at(&TilePlaces::v, i);
            const auto inverse_depth = move_by_parallax(d, parallax, u, v);
            hn::Store(inverse_depth, d, found.inverse_depth + i * lanes);
            const auto x = first_of_two(u, z_.width()), y = first_of_two(v, z_.height());
            hn::Store(hn::Add(hn::Mul(y, hn::Set(di, z_.stride())), x), di,
                      found.first + i * lanes);
            hn::Store(hn::Sub(u, hn::ConvertTo(d, x)), d, found.right + i * lanes);
            hn::Store(hn::Sub(v, hn::ConvertTo(d, y)), d, found.down + i * lanes);
        }
    }

    template <class D, class Pixels>
    HWY_INLINE void see_surface(D d, const Neighbourhoods &at, Pixels &pixels) const {
        const hn::RebindToSigned<D> di;
        const hn::RebindToUnsigned<D> du;
        const hn::Rebind<std::uint16_t, D> d16;
        constexpr int lanes = static_cast<int>(hn::MaxLanes(D()));
        const auto parallax = parallax_of(d, tile_);
        const auto half = hn::Set(d, 0.5f);
        // As unsigned numbers the bits of negative floats, and of NaN, are beyond all others.
        const auto below = [&](auto value, float limit) HWY_ATTR {
            return hn::RebindMask(
                di, hn::Lt(hn::BitCast(du, value), hn::BitCast(du, hn::Set(d, limit))));
        };
        for (int i = 0; i < pixels.vectors(); ++i) {
            const Place<hn::Vec<D>> place = {hn::Load(d, at.right + i * lanes),
                                             hn::Load(d, at.down + i * lanes),
                                             hn::Load(d, at.inverse_depth + i * lanes)};
            const auto seen = surface_seen_at(d, z_, at.first + i * lanes, place, parallax);
            const auto edge = edge_of(d, seen.point);
            auto there = hn::And(hn::Gt(edge, hn::Set(di, least_edge_distance_ - 1)),
                                 hn::And(below(hn::Add(place.right, half), 2.0f),
                                         below(hn::Add(place.down, half), 2.0f)));
            if constexpr (searched) {
                const auto moved = hn::Add(hn::Abs(seen.moved_u), hn::Abs(seen.moved_v));
                there = hn::And(there, below(moved, most_missed_px));
            }
            const auto reading = hn::Add(hn::Mul(seen.depth, pixels.at(&TilePlaces::scale, i)),
                                         pixels.at(&TilePlaces::shift, i));
            const auto whole = hn::IfThenElseZero(there, hn::ConvertTo(di, hn::Add(reading, half)));
            pixels.put(i, hn::DemoteTo(d16, whole), hn::IfThenElseZero(there, edge),
                       place.inverse_depth);
        }
    }

    /// With the depths of the points themselves.
    template <class D, class Pixels>
    HWY_INLINE void see_points(D d, Pixels &pixels) const {
        const hn::RebindToSigned<D> di;
        const hn::RebindToUnsigned<D> du;
        const hn::Rebind<std::uint16_t, D> d16;
        const auto parallax = parallax_of(d, tile_);
        const auto half = hn::Set(d, 0.5f);
        const auto inside = [&](auto place, int end) HWY_ATTR {
            return hn::RebindMask(
                di, hn::Lt(hn::BitCast(du, place), hn::Set(du, static_cast<std::uint32_t>(end))));
        };
        for (int i = 0; i < pixels.vectors(); ++i) {
            auto u = pixels.at(&TilePlaces::u, i), v = pixels.at(&TilePlaces::v, i);
            const auto inverse_depth = move_by_parallax(d, parallax, u, v);
            const auto x = hn::ConvertTo(di, hn::Add(u, half));
            const auto y = hn::ConvertTo(di, hn::Add(v, half));
            const auto in_picture = hn::And(inside(x, z_.width()), inside(y, z_.height()));
            const auto place = hn::Add(hn::Mul(y, hn::Set(di, z_.stride())), x);
            const auto point = gather(d, z_.data(), hn::IfThenElseZero(in_picture, place));
            const auto edge = edge_of(d, point);
            auto there = hn::And(in_picture, hn::Gt(edge, hn::Set(di, least_edge_distance_ - 1)));
            if constexpr (searched) {
                // |1 / point - inverse_depth| parallax < most_missed_px
                const auto off = hn::Abs(hn::Sub(hn::Set(d, 1.0f), hn::Mul(inverse_depth, point)));
                const auto least = hn::Mul(off, hn::Set(d, tile_.parallax_px() / most_missed_px));
                there =
                    hn::And(there, hn::RebindMask(di, hn::Lt(order(d, least), order(d, point))));
            }
            const auto reading = hn::Add(hn::Mul(point, pixels.at(&TilePlaces::scale, i)),
                                         pixels.at(&TilePlaces::shift, i));
            const auto whole = hn::IfThenElseZero(there, hn::ConvertTo(di, hn::Add(reading, half)));
            pixels.put(i, hn::DemoteTo(d16, whole), hn::IfThenElseZero(there, edge), inverse_depth);
        }
    }

    const MappedTile &tile_;
    TilePlaces places_;
    ImageView<const float> z_;
    int least_edge_distance_;
};

/// Calls work(look_up) with what looks up points of a tile.
template <class Work>
auto with_points(const MappedTile &tile, ImageView<const float> z, int least_edge_distance,
                 const Work &work) {
    if (tile.searched)
        return work(ParallaxPoints<true>(tile, z, least_edge_distance));
    return work(ParallaxPoints<false>(tile, z, least_edge_distance));
}

void look_up_parallax(const MappedTile &tile, ImageView<const float> z, int least_edge_distance,
                      const BlockNodes &nodes) {
    with_points(tile, z, least_edge_distance,
                [&](const auto &look_up) { see_nodes(tile, look_up, nodes); });
}

int draw_parallax(const MappedTile &tile, ImageView<const float> z, int least_edge_distance,
                  ImageView<const std::uint8_t> even, ImageView<std::uint16_t> millimetres,
                  ImageView<std::uint8_t> edge_distance) {
    return with_points(tile, z, least_edge_distance, [&](const auto &look_up) {
        return draw_uneven_columns(look_up, even, {millimetres, edge_distance});
    });
}

} // namespace
} // namespace afterglow::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace afterglow {
namespace {

HWY_EXPORT(look_up_parallax);
HWY_EXPORT(draw_parallax);

} // namespace

void look_up_nodes_by_parallax(const MappedTile &tile, ImageView<const float> z,
                               int least_edge_distance, const BlockNodes &nodes) {
    HWY_DYNAMIC_DISPATCH(look_up_parallax)(tile, z, least_edge_distance, nodes);
}

int draw_uneven_by_parallax(const MappedTile &tile, ImageView<const float> z,
                            int least_edge_distance, ImageView<const std::uint8_t> even,
                            ImageView<std::uint16_t> millimetres,
                            ImageView<std::uint8_t> edge_distance) {
    return HWY_DYNAMIC_DISPATCH(draw_parallax)(tile, z, least_edge_distance, even, millimetres,
                                               edge_distance);
}

} // namespace afterglow
#endif
