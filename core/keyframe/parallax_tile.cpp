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
/// How often a point is searched for where the last one found is seen.
constexpr int search_steps = 2;

/// The depths of four neighbours, metres, 0 = none: at the left and right, then below.
template <class V>
struct Neighbours {
    V a, b, c, e;
};
/// Those whose first ones are at as many places of the surface's depths.
template <class D>
HWY_API Neighbours<hn::Vec<D>> neighbours_at(D d, ImageView<const float> z,
                                             const std::int32_t *places) {
    const float *const upper = z.data(), *const lower = z.row(1);
#if HWY_TARGET != HWY_SCALAR // which has no pairs
    // Such instruction sets load two at once, but look up one by one.
    if constexpr (hn::MaxLanes(D()) == 4) {
        const hn::Half<D> pair;
        const auto two = [&](const float *from, int i) HWY_ATTR {
            return hn::Combine(d, hn::LoadU(pair, from + places[i + 1]),
                               hn::LoadU(pair, from + places[i]));
        };
        const auto above = two(upper, 0), above2 = two(upper, 2);
        const auto below = two(lower, 0), below2 = two(lower, 2);
        return {hn::ConcatEven(d, above2, above), hn::ConcatOdd(d, above2, above),
                hn::ConcatEven(d, below2, below), hn::ConcatOdd(d, below2, below)};
    }
#endif
    const auto at = hn::Load(hn::RebindToSigned<D>(), places);
    return {hn::GatherIndex(d, upper, at), hn::GatherIndex(d, upper + 1, at),
            hn::GatherIndex(d, lower, at), hn::GatherIndex(d, lower + 1, at)};
}

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
    const auto [a, b, c, e] = neighbours;
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

/// What the pixels of a tile's columns look up, row by row: where the surface's depths have the
/// first of four neighbours, how far the pixel is from that one, columns and rows, and the inverse
/// depth, 1/m, of points that are seen there.
template <class D>
struct LookUps {
    static constexpr int lanes = static_cast<int>(hn::MaxLanes(D()));
    static constexpr int count = mapped_tile_px * lanes;
    HWY_ALIGN std::int32_t first[count];
    HWY_ALIGN float right[count], down[count], inverse_depth[count];

    /// Those of one row.
    template <class V>
    HWY_INLINE void set(D d, int row, V u, V v, V inverse, ImageView<const float> z) {
        const hn::RebindToSigned<D> di;
        const auto whole = [&](V place, int size) HWY_ATTR {
            const auto at = hn::ConvertTo(di, place);
            return hn::Min(hn::Max(at, hn::Zero(di)), hn::Set(di, size - 2));
        };
        const auto x = whole(u, z.width()), y = whole(v, z.height());
        const int at = row * lanes;
        hn::Store(hn::Add(hn::Mul(y, hn::Set(di, z.stride())), x), di, first + at);
        hn::Store(hn::Sub(u, hn::ConvertTo(d, x)), d, right + at);
        hn::Store(hn::Sub(v, hn::ConvertTo(d, y)), d, down + at);
        hn::Store(inverse, d, inverse_depth + at);
    }
};

/// The inverse depths, 1/m, of the nearest points to some places; `missing` where there is none.
template <class D, class V>
HWY_API V inverse_depth_near(D d, ImageView<const float> z, V u, V v, float missing) {
    const hn::RebindToSigned<D> di;
    const auto nearest = [&](V place, int size) HWY_ATTR {
        const auto at = hn::ConvertTo(di, hn::Add(place, hn::Set(d, 0.5f)));
        return hn::Min(hn::Max(at, hn::Zero(di)), hn::Set(di, size - 1));
    };
    const auto x = nearest(u, z.width()), y = nearest(v, z.height());
    const auto point =
        hn::GatherIndex(d, z.data(), hn::Add(hn::Mul(y, hn::Set(di, z.stride())), x));
    const auto hole = hn::RebindMask(d, hn::Eq(hn::BitCast(di, point), hn::Zero(di)));
    return hn::IfThenElse(hole, hn::Set(d, missing), hn::Div(hn::Set(d, 1.0f), point));
}

/// What is seen at the places of `tile` that its corners put into the columns from `first` on: the
/// points themselves if they are displaced alike; else those that are found from the nearest depth
/// on, the place being moved by the parallax of what is there. So of several points that are seen
/// on one pixel the nearest is found, unless it is narrower than the way to it.
template <bool searched, class D>
HWY_API void find_look_ups(D d, const MappedTile &tile, ImageView<const float> z, int first,
                           LookUps<D> &look_ups) {
    const MappedCorner &a = tile.corners[0], &b = tile.corners[1];
    const MappedCorner &c = tile.corners[2], &e = tile.corners[3];
    const auto parallax = parallax_of(d, tile);
    auto u = between(d, first, a.u, b.u, c.u, e.u), v = between(d, first, a.v, b.v, c.v, e.v);
    for (int row = 0; row < mapped_tile_px; ++row) {
        auto at_u = u.value, at_v = v.value, inverse_depth = parallax.inverse_depth;
        if constexpr (searched)
            for (int step = 0; step < search_steps; ++step) {
                inverse_depth = inverse_depth_near(d, z, at_u, at_v, tile.farthest_inverse_depth);
                const auto excess = hn::Sub(inverse_depth, parallax.inverse_depth);
                at_u = hn::Sub(u.value, hn::Mul(parallax.u, excess));
                at_v = hn::Sub(v.value, hn::Mul(parallax.v, excess));
            }
        look_ups.set(d, row, at_u, at_v, inverse_depth, z);
        for (auto *const of : {&u, &v})
            of->value = hn::Add(of->value, of->step);
    }
}

/// Draws a tile that is not of one surface.
template <bool in_picture, bool searched>
int draw_tile_by_parallax(const MappedTile &tile, ImageView<const float> z, int least_edge_distance,
                          const DrawnTile &to) {
    using Floats = hn::CappedTag<float, mapped_tile_px>;
    const Floats d;
    const hn::RebindToSigned<decltype(d)> di;
    const hn::RebindToUnsigned<decltype(d)> du;
    const auto parallax = parallax_of(d, tile);
    const MappedCorner &a = tile.corners[0], &b = tile.corners[1];
    const MappedCorner &c = tile.corners[2], &e = tile.corners[3];
    const auto below_least = hn::Set(di, least_edge_distance - 1);
    auto found = hn::Zero(di);
    LookUps<Floats> look_ups;
    constexpr int lanes = look_ups.lanes;
    // In two passes: the registers of small targets do not hold what both need.
    for (int i = 0; i < mapped_tile_px; i += lanes) {
        find_look_ups<searched>(Floats(), tile, z, i, look_ups);
        auto scale = between(d, i, a.scale, b.scale, c.scale, e.scale);
        auto shift = between(d, i, a.shift + 0.5f, b.shift + 0.5f, c.shift + 0.5f, e.shift + 0.5f);
        DrawnColumns columns(to, i);
        for (int row = 0; row < mapped_tile_px; ++row) {
            const int at = row * lanes;
            const auto right = hn::Load(d, look_ups.right + at);
            const auto down = hn::Load(d, look_ups.down + at);
            const auto inverse =
                searched ? hn::Load(d, look_ups.inverse_depth + at) : parallax.inverse_depth;
            const auto seen = seen_at(d, neighbours_at(d, z, look_ups.first + at), right, down,
                                      inverse, parallax);
            const auto edge = edge_of(d, seen.point);
            auto there = hn::Gt(edge, below_least);
            // As unsigned numbers the bits of negative floats, and of NaN, are beyond all others.
            const auto below = [&](auto value, float limit) HWY_ATTR {
                return hn::RebindMask(
                    di, hn::Lt(hn::BitCast(du, value), hn::BitCast(du, hn::Set(d, limit))));
            };
            if constexpr (searched) {
                const auto moved = hn::Add(hn::Abs(seen.moved_u), hn::Abs(seen.moved_v));
                there = hn::And(there, below(moved, most_missed_px));
            }
            if constexpr (!in_picture) {
                const auto near_first = [&](auto distance) HWY_ATTR {
                    return below(hn::Add(distance, hn::Set(d, 0.5f)), 2.0f);
                };
                there = hn::And(there, hn::And(near_first(right), near_first(down)));
            }
            found = hn::Sub(found, hn::VecFromMask(di, there));
            columns.draw(d, hn::Add(hn::Mul(seen.depth, scale.value), shift.value), edge, there);
            for (auto *const of : {&scale, &shift})
                of->value = hn::Add(of->value, of->step);
        }
    }
    return hn::GetLane(hn::SumOfLanes(di, found));
}

int draw_parallax(const MappedTile &tile, ImageView<const float> z, int least_edge_distance,
                  ImageView<std::uint16_t> millimetres, ImageView<std::uint8_t> edge_distance) {
    const auto draw_it = tile.searched     ? draw_tile_by_parallax<false, true>
                         : tile.in_picture ? draw_tile_by_parallax<true, false>
                                           : draw_tile_by_parallax<false, false>;
    return draw_it(tile, z, least_edge_distance, {millimetres, edge_distance});
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
