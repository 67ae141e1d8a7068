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
/// and rows. The depth is bilinear between the four points around the place, moved by that, unless
/// one of them is missing or the point is beside an edge: they may be of another surface.
template <class V>
struct SeenPoint {
    V point, depth, moved_u, moved_v;
};
/// `inverse_depth`: of points that are seen at their places, 1/m.
template <class D, class V>
HWY_API SeenPoint<V> seen_at(D d, const Neighbours<V> &neighbours, V right, V down, V inverse_depth,
                             const Parallax<V> &parallax) {
    const hn::RebindToSigned<D> di;
    const hn::RebindToUnsigned<D> du;
    const auto [a, b, c, e] = neighbours; // metres, 0 = none
    const auto half = order(d, hn::Set(d, 0.5f));
    const auto is_right = hn::RebindMask(d, hn::Not(hn::Lt(order(d, right), half)));
    const auto is_below = hn::RebindMask(d, hn::Not(hn::Lt(order(d, down), half)));
    const auto point =
        hn::IfThenElse(is_below, hn::IfThenElse(is_right, e, c), hn::IfThenElse(is_right, b, a));
    const auto bits = [&](V value) HWY_ATTR { return hn::BitCast(du, value); };
    const auto least = hn::Min(hn::Min(bits(a), bits(b)), hn::Min(bits(c), bits(e)));
    const auto inside = hn::And(hn::Gt(edge_of(d, point), hn::Set(di, beside_edge)),
                                hn::RebindMask(di, hn::Ne(least, hn::Zero(du))));
    const auto excess = hn::Sub(hn::Div(hn::Set(d, 1.0f), point), inverse_depth);
    const auto moved_u = hn::Mul(parallax.u, excess), moved_v = hn::Mul(parallax.v, excess);
    const auto x = hn::Sub(right, moved_u), y = hn::Sub(down, moved_v);
    const auto across = hn::Sub(b, a);
    const auto above = hn::Add(a, hn::Mul(x, across));
    const auto step = hn::Add(hn::Sub(c, a), hn::Mul(x, hn::Sub(hn::Sub(e, c), across)));
    const auto between = hn::Add(above, hn::Mul(y, step));
    const auto most = hn::Mul(hn::Set(d, 1 + steepest), point);
    const auto limited = hn::Max(hn::Min(between, most), hn::Mul(hn::Set(d, 1 - steepest), point));
    return {point, hn::IfThenElse(hn::RebindMask(d, inside), limited, point), moved_u, moved_v};
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
    /// In two passes: the registers of small targets do not hold what both need.
    template <class D, class Pixels>
    HWY_INLINE void operator()(D d, Pixels &pixels) const {
        Neighbourhoods at;
        find(d, pixels, at);
        see(d, at, pixels);
    }

private:
    /// Where the surface's depths have the first of four neighbours, how far a place is from that
    /// one, columns and rows, and the inverse depth, 1/m, of points that are seen there.
    struct Neighbourhoods {
        HWY_ALIGN std::int32_t first[most_pixels];
        HWY_ALIGN float right[most_pixels], down[most_pixels], inverse_depth[most_pixels];
    };

    template <class D, class Pixels>
    HWY_INLINE void find(D d, const Pixels &pixels, Neighbourhoods &found) const {
        const hn::RebindToSigned<D> di;
        constexpr int lanes = static_cast<int>(hn::MaxLanes(D()));
        const auto parallax = parallax_of(d, tile_);
        const auto first_of_two = [&](auto place, int size) HWY_ATTR {
            const auto at = hn::ConvertTo(di, place);
            return hn::Min(hn::Max(at, hn::Zero(di)), hn::Set(di, size - 2));
        };
        for (int i = 0; i < Pixels::vectors; ++i) {
            auto u = pixels.at(&TilePlaces::u, i), v = pixels.at(&TilePlaces::v, i);
            if constexpr (searched) {
                const auto inverse_depth =
                    inverse_depth_near(d, z_, u, v, tile_.farthest_inverse_depth);
                const auto excess = hn::Sub(inverse_depth, parallax.inverse_depth);
                u = hn::Sub(u, hn::Mul(parallax.u, excess));
                v = hn::Sub(v, hn::Mul(parallax.v, excess));
                hn::Store(inverse_depth, d, found.inverse_depth + i * lanes);
            }
            const auto x = first_of_two(u, z_.width()), y = first_of_two(v, z_.height());
            hn::Store(hn::Add(hn::Mul(y, hn::Set(di, z_.stride())), x), di,
                      found.first + i * lanes);
            hn::Store(hn::Sub(u, hn::ConvertTo(d, x)), d, found.right + i * lanes);
            hn::Store(hn::Sub(v, hn::ConvertTo(d, y)), d, found.down + i * lanes);
        }
    }

    template <class D, class Pixels>
    HWY_INLINE void see(D d, const Neighbourhoods &at, Pixels &pixels) const {
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
        for (int i = 0; i < Pixels::vectors; ++i) {
            const auto right = hn::Load(d, at.right + i * lanes);
            const auto down = hn::Load(d, at.down + i * lanes);
            const auto inverse_depth =
                searched ? hn::Load(d, at.inverse_depth + i * lanes) : parallax.inverse_depth;
            const auto seen =
                seen_at(d, neighbours_at(d, z_.data(), z_.stride(), at.first + i * lanes), right,
                        down, inverse_depth, parallax);
            const auto edge = edge_of(d, seen.point);
            auto there = hn::And(
                hn::Gt(edge, hn::Set(di, least_edge_distance_ - 1)),
                hn::And(below(hn::Add(right, half), 2.0f), below(hn::Add(down, half), 2.0f)));
            if constexpr (searched) {
                const auto moved = hn::Add(hn::Abs(seen.moved_u), hn::Abs(seen.moved_v));
                there = hn::And(there, below(moved, most_missed_px));
            }
            const auto reading = hn::Add(hn::Mul(seen.depth, pixels.at(&TilePlaces::scale, i)),
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

int draw_parallax(const MappedTile &tile, ImageView<const float> z, int least_edge_distance,
                  ImageView<std::uint16_t> millimetres, ImageView<std::uint8_t> edge_distance) {
    const DrawnTile to = {millimetres, edge_distance};
    if (tile.searched)
        return draw_tile<true>(tile, ParallaxPoints<true>(tile, z, least_edge_distance), to);
    return draw_tile<false>(tile, ParallaxPoints<false>(tile, z, least_edge_distance), to);
}

} // namespace
} // namespace afterglow::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace afterglow {
namespace {

HWY_EXPORT(draw_parallax);

} // namespace

int draw_by_parallax(const MappedTile &tile, ImageView<const float> z, int least_edge_distance,
                     ImageView<std::uint16_t> millimetres, ImageView<std::uint8_t> edge_distance) {
    return HWY_DYNAMIC_DISPATCH(draw_parallax)(tile, z, least_edge_distance, millimetres,
                                               edge_distance);
}

} // namespace afterglow
#endif
