// SPDX-License-Identifier: Apache-2.0
// Compiled once for each instruction set; the best of them is chosen when first called.
#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "core/warp/warp_kernels.cpp"
#include "core/warp/warp_kernels.hpp"

#include "core/warp/mapped_tile.hpp"

#include <algorithm>
#include <hwy/foreach_target.h>
#include <hwy/highway.h>

// clang-format off: after Highway, once for each instruction set
#include "core/base/lanes-inl.hpp"
#include "core/surface/surface_point-inl.hpp"
// clang-format on

HWY_BEFORE_NAMESPACE();
namespace afterglow::HWY_NAMESPACE {
namespace {

/// A homogeneous pixel in vectors.
template <class V>
struct Homogeneous {
    V across, down, depth;
};

/// Points of a row with depths z at columns u.
template <class D, class V>
HWY_API Homogeneous<V> seen_at(D d, const RowProjection &by, V u, V z) {
    const auto along = [&](int k) HWY_ATTR {
        const auto ray = hn::Add(hn::Mul(hn::Set(d, by.by_column[k]), u), hn::Set(d, by.origin[k]));
        return hn::Add(hn::Mul(z, ray), hn::Set(d, by.shift[k]));
    };
    return {along(0), along(1), along(2)};
}

/// The same points when the row on which they are seen is read.
template <class D, class V>
HWY_API Homogeneous<V> when_read(D d, const RowMotion &motion, const Homogeneous<V> &at) {
    const auto half = hn::Set(d, 0.5f);
    const auto row = hn::Div(at.down, at.depth);
    const auto t = hn::Mul(hn::Sub(row, hn::Set(d, motion.middle)), hn::Set(d, motion.per_row));
    const auto part = hn::Min(hn::Max(t, hn::Set(d, -0.5f)), half);
    const auto moved = [&](V value, int k) HWY_ATTR {
        const auto turned = hn::Add(hn::Mul(hn::Set(d, motion.turn(k, 0)), at.across),
                                    hn::Add(hn::Mul(hn::Set(d, motion.turn(k, 1)), at.down),
                                            hn::Mul(hn::Set(d, motion.turn(k, 2)), at.depth)));
        return hn::Add(value, hn::Mul(part, hn::Add(turned, hn::Set(d, motion.shift[k]))));
    };
    return {moved(at.across, 0), moved(at.down, 1), moved(at.depth, 2)};
}

/// The points beside some points, metres, 0 = none.
template <class V>
struct Around {
    V left, right, above, below;
};

/// How much the depth, metres, changes from points with that edge distance and depth to places that
/// are `along` columns and `down` rows from them: by the slope between the points around, at most
/// `steepest`. 0 where one of these is missing or the point is beside an edge: they may be of
/// another surface.
template <class D, class VI, class V>
HWY_API V rise(D d, VI edge, const Around<V> &around, V depth, V along, V down) {
    const hn::RebindToSigned<D> di;
    const hn::RebindToUnsigned<D> du;
    const auto bits = [&](V value) HWY_ATTR { return hn::BitCast(du, value); };
    const auto least = hn::Min(hn::Min(bits(around.left), bits(around.right)),
                               hn::Min(bits(around.above), bits(around.below)));
    const auto inside = hn::And(hn::Gt(edge, hn::Set(di, beside_edge)),
                                hn::RebindMask(di, hn::Ne(least, hn::Zero(du))));
    const auto most = hn::Mul(hn::Set(d, steepest), depth);
    const auto least_step = hn::Mul(hn::Set(d, -steepest), depth); // Neg() is slow on ARMv7
    const auto slope = [&](V from, V to) HWY_ATTR {
        const auto step = hn::Mul(hn::Set(d, 0.5f), hn::Sub(to, from));
        return hn::Min(hn::Max(step, least_step), most);
    };
    const auto found = hn::Add(hn::Mul(slope(around.left, around.right), along),
                               hn::Mul(slope(around.above, around.below), down));
    return hn::IfThenElseZero(hn::RebindMask(d, inside), found);
}

void project(const PointRow &points, const RowProjection &projection, const RowMotion &rows,
             const LandingLimits &landing, int *HWY_RESTRICT offsets,
             WarpedPixel *HWY_RESTRICT values) {
    // Copies, which nothing written here can change.
    const PointRow in = points;
    const RowProjection by = projection;
    const RowMotion motion = rows;
    const LandingLimits limits = landing;
    // In two passes: the registers of small targets do not hold what both need.
    struct Places {
        HWY_ALIGN float x[most_points], y[most_points], depth[most_points];
    };
    Places places;
    float *const HWY_RESTRICT xs = places.x;
    float *const HWY_RESTRICT ys = places.y;
    float *const HWY_RESTRICT depths = places.depth;
    for_overlapping_lanes(in.count, [&](auto d, int i) HWY_ATTR {
        const hn::RebindToSigned<decltype(d)> di;
        const auto half = hn::Set(d, 0.5f);
        auto z = hn::LoadU(d, in.z + i + 1);
        if (limits.hides_below > 0) {
            const auto edge = edge_of(d, z);
            const auto zero = hn::Zero(d);
            const auto hides = hn::And(
                hn::RebindMask(d, hn::Lt(edge, hn::Set(di, limits.hides_below))), hn::Ne(z, zero));
            const auto there = [&](const float *neighbour) HWY_ATTR {
                const auto at = hn::LoadU(d, neighbour);
                return hn::IfThenElse(hn::Eq(at, zero), z, at);
            };
            const auto nearest = hn::Min(hn::Min(there(in.z + i), there(in.z + i + 2)),
                                         hn::Min(there(in.above + i), there(in.below + i)));
            z = hn::IfThenElse(hides, hn::Min(z, nearest), z);
        }
        auto at = seen_at(d, by, ramp(d, in.first_column + i), z);
        if (motion.any)
            at = when_read(d, motion, at);
        const auto inverse = hn::Div(hn::Set(d, 1.0f), at.depth);
        hn::StoreU(hn::Add(hn::Mul(at.across, inverse), half), d, xs + i);
        hn::StoreU(hn::Add(hn::Mul(at.down, inverse), half), d, ys + i);
        hn::StoreU(at.depth, d, depths + i);
    });
    for_overlapping_lanes(in.count, [&](auto d, int i) HWY_ATTR {
        const hn::RebindToSigned<decltype(d)> di;
        const auto half = hn::Set(d, 0.5f);
        const auto x = hn::LoadU(d, xs + i), y = hn::LoadU(d, ys + i);
        const auto depth = hn::LoadU(d, depths + i);
        const auto edge = edge_of(d, hn::LoadU(d, in.z + i + 1));
        const hn::RebindToUnsigned<decltype(d)> du;
        const auto bits = [&](auto value) HWY_ATTR { return hn::BitCast(du, value); };
        // As unsigned numbers the bits of negative floats, and of NaN, are beyond all others.
        const auto below_limit = [&](auto value, float limit) HWY_ATTR {
            return hn::Lt(bits(value), bits(hn::Set(d, limit)));
        };
        const auto in_depth =
            hn::AndNot(below_limit(depth, limits.nearest), below_limit(depth, limits.farthest));
        const auto in_view =
            hn::And(in_depth, hn::And(below_limit(x, limits.width), below_limit(y, limits.height)));
        const auto carried = hn::Gt(edge, hn::Set(di, limits.least_edge_distance - 1));
        const auto lands = hn::And(carried, hn::RebindMask(di, in_view));
        const auto column = truncated(di, hn::IfThenElseZero(hn::RebindMask(d, lands), x));
        const auto row = truncated(di, hn::IfThenElseZero(hn::RebindMask(d, lands), y));

        const auto to_centre = [&](auto pixel, auto place) HWY_ATTR {
            return hn::Sub(hn::ConvertTo(d, pixel), hn::Sub(place, half));
        };
        const Around<hn::Vec<decltype(d)>> around = {
            hn::LoadU(d, in.z + i), hn::LoadU(d, in.z + i + 2), hn::LoadU(d, in.above + i),
            hn::LoadU(d, in.below + i)};
        const auto moved =
            hn::Add(depth, rise(d, edge, around, depth, to_centre(column, x), to_centre(row, y)));
        const auto units =
            truncated(di, hn::Add(hn::Mul(moved, hn::Set(d, warped_units_per_m)), half));
        const auto value = hn::Or(hn::ShiftLeft<warped_depth_shift>(units), edge);
        hn::StoreU(hn::IfThenElse(lands, value, hn::Set(di, nothing_landed)), di, values + i);
        hn::StoreU(hn::Add(hn::Mul(row, hn::Set(di, limits.stride)), column), di, offsets + i);
    });
}

void doubt(const ScatteredRows &in, WarpedPixel *HWY_RESTRICT out,
           std::uint8_t *HWY_RESTRICT doubtful) {
    for_overlapping_lanes(in.count, [&](auto d, int i) HWY_ATTR {
        const hn::RebindToSigned<decltype(d)> di;
        const hn::Rebind<std::uint8_t, decltype(d)> d8;
        const auto nothing = hn::Set(di, nothing_landed);
        const auto here = hn::LoadU(di, in.row + i);
        const auto left = hn::LoadU(di, in.row + i - 1), right = hn::LoadU(di, in.row + i + 1);
        // All bits of nothing_landed are set: only nothing stays nothing.
        const auto three = [&](const WarpedPixel *row) HWY_ATTR {
            return hn::And(hn::LoadU(di, row + i - 1),
                           hn::And(hn::LoadU(di, row + i), hn::LoadU(di, row + i + 1)));
        };
        const auto around =
            hn::And(hn::And(left, right), hn::And(three(in.above), three(in.below)));
        const auto empty = hn::Eq(here, nothing);
        const auto lonely = hn::Eq(around, nothing);
        const auto behind =
            hn::Not(hn::Gt(hn::Min(left, right), hn::Sub(here, hn::ShiftRight<5>(here))));
        const auto suspect = hn::Or(hn::And(hn::Not(lonely), empty), hn::AndNot(empty, behind));
        const auto mark = hn::IfThenElseZero(suspect, hn::Set(di, 1));
        hn::StoreU(hn::IfThenZeroElse(empty, here), di, out + i);
        hn::StoreU(hn::DemoteTo(d8, mark), d8, doubtful + i);
    });
}

int readings(const WarpedRow &row, std::uint16_t *HWY_RESTRICT millimetres,
             std::uint8_t *HWY_RESTRICT edges) {
    const WarpedRow in = row; // a copy, which nothing written here can change
    constexpr float unit_mm = 1000.0f / warped_units_per_m;
    int found = 0;
    for_lanes(in.count, [&](auto d, int i) HWY_ATTR {
        const hn::RebindToSigned<decltype(d)> di;
        const hn::Rebind<std::uint16_t, decltype(d)> d16;
        const hn::Rebind<std::uint8_t, decltype(d)> d8;
        const auto pixel = hn::LoadU(di, in.pixels + i);
        const auto factor = hn::Add(hn::Set(d, unit_mm * in.relative),
                                    hn::Mul(hn::Set(d, unit_mm * in.step), ramp(d, i)));
        const auto units = hn::ConvertTo(d, hn::ShiftRight<warped_depth_shift>(pixel));
        const auto whole = truncated(di, hn::Add(hn::Mul(units, factor), hn::Set(d, 0.5f)));
        const auto edge = hn::And(pixel, hn::Set(di, warped_edge_mask));
        hn::StoreU(hn::DemoteTo(d16, whole), d16, millimetres + i);
        hn::StoreU(hn::DemoteTo(d8, edge), d8, edges + i);
        found += static_cast<int>(hn::CountTrue(di, hn::Gt(pixel, hn::Zero(di))));
    });
    return found;
}

void tile_ranges(const PieceRow &pieces, const PieceProjection &projection,
                 TileRange *HWY_RESTRICT ranges) {
    // Copies, which nothing written here can change.
    const PieceRow in = pieces;
    const PieceProjection by = projection;
    const RowMotion motion = projection.rows;
    for_overlapping_lanes(in.count, [&](auto d, int i) HWY_ATTR {
        constexpr float beyond_all = 1e9f;
        using V = hn::Vec<decltype(d)>;
        const hn::RebindToSigned<decltype(d)> di;
        const hn::Rebind<std::int16_t, decltype(d)> d16;
        const auto set = [&](float value) HWY_ATTR { return hn::Set(d, value); };
        const auto u = hn::Add(set(in.first_centre), hn::Mul(set(in.size), ramp(d, i)));
        struct Box {
            V left, right, top, bottom;
        };
        const auto box = [&](V z, auto &in_front) HWY_ATTR {
            auto at = seen_at(d, by.row, u, z);
            if (motion.any)
                at = when_read(d, motion, at);
            in_front = hn::And(hn::Gt(order(d, at.depth), order(d, set(by.nearest))),
                               hn::Lt(order(d, at.depth), order(d, set(beyond_all))));
            const auto inverse = hn::Div(set(1.0f), at.depth);
            const auto x = hn::Mul(at.across, inverse), y = hn::Mul(at.down, inverse);
            // The derivative of a point's place in the view by its pixel, times half the size.
            const auto half = hn::Mul(set(0.5f * in.size), hn::Mul(z, inverse));
            const auto extent = [&](V place, int k) HWY_ATTR {
                const auto along = [&](int j) HWY_ATTR {
                    return hn::Abs(hn::Sub(set(by.turn(k, j)), hn::Mul(place, set(by.turn(2, j)))));
                };
                return hn::Mul(half, hn::Add(along(0), along(1)));
            };
            const auto across = extent(x, 0), down = extent(y, 1);
            return Box{hn::Sub(x, across), hn::Add(x, across), hn::Sub(y, down), hn::Add(y, down)};
        };
        hn::Mask<decltype(di)> near_in_front, far_in_front;
        const auto z = hn::LoadU(d, in.farthest + i);
        const Box near = box(hn::LoadU(d, in.nearest + i), near_in_front);
        const Box far = box(z, far_in_front);
        const auto there = hn::Ne(order(d, z), hn::Zero(di));
        const auto seen = hn::And(there, hn::Or(near_in_front, far_in_front));
        const auto all = hn::RebindMask(d, hn::And(near_in_front, far_in_front));
        const V left = hn::Min(near.left, far.left), right = hn::Max(near.right, far.right);
        const V top = hn::Min(near.top, far.top), bottom = hn::Max(near.bottom, far.bottom);
        // From -1 to count, however far away it is.
        const auto tile = [&](V place, int count) HWY_ATTR {
            const auto from_before = hn::Add(hn::Mul(place, set(1.0f / mapped_tile_px)), set(1.0f));
            const auto inside =
                hn::Min(hn::Max(from_before, set(0)), set(static_cast<float>(count + 1)));
            return hn::Sub(truncated(di, inside), hn::Set(di, 1));
        };
        const auto first = [&](V place, int count) HWY_ATTR {
            const auto reached = hn::IfThenElseZero(all, hn::Sub(place, set(by.margin)));
            return hn::DemoteTo(d16, hn::Max(tile(reached, count), hn::Zero(di)));
        };
        const auto last = [&](V place, int count) HWY_ATTR {
            const auto reached =
                hn::IfThenElse(all, hn::Add(place, set(by.margin)), set(beyond_all));
            const auto most = hn::Min(tile(reached, count), hn::Set(di, count - 1));
            return hn::DemoteTo(d16, hn::IfThenElse(seen, most, hn::Set(di, -1)));
        };
        hn::StoreInterleaved4(first(left, by.columns), last(right, by.columns),
                              first(top, by.lines), last(bottom, by.lines), d16, &ranges[i].left);
    });
}

void add_parts(const SurfacePart *parts, std::span<const TileRange> ranges,
               ImageView<SurfacePart> tiles) {
    const hn::CappedTag<std::uint32_t, SurfacePart::values> d;
    constexpr std::size_t lanes = hn::MaxLanes(d);
    for (std::size_t at = 0; at < ranges.size(); ++at) {
        const TileRange &range = ranges[at];
        const SurfacePart &part = parts[at];
        if (range.left > range.right || range.top > range.bottom)
            continue;
        if (range.right - range.left > 1 || range.bottom - range.top > 1) {
            SurfacePart seen = part;
            // All pieces of a row that are partly behind the camera may be seen on all tiles.
            for (; at + 1 < ranges.size() && ranges[at + 1] == range; ++at)
                seen.add(parts[at + 1]);
            for (int y = range.top; y <= range.bottom; ++y)
                for (int x = range.left; x <= range.right; ++x)
                    tiles(x, y).add(seen);
            continue;
        }
        // At most four tiles, of which some may be the same one.
        SurfacePart *const above = tiles.row(range.top), *const below = tiles.row(range.bottom);
        std::uint32_t *const a = above[range.left].most().data();
        std::uint32_t *const b = above[range.right].most().data();
        std::uint32_t *const c = below[range.left].most().data();
        std::uint32_t *const e = below[range.right].most().data();
        for (std::size_t i = 0; i < SurfacePart::values; i += lanes) {
            const auto seen = hn::Load(d, part.most().data() + i);
            const auto with = [&](const std::uint32_t *most)
                                  HWY_ATTR { return hn::Max(seen, hn::Load(d, most + i)); };
            const auto to_a = with(a), to_b = with(b), to_c = with(c), to_e = with(e);
            hn::Store(to_a, d, a + i);
            hn::Store(to_b, d, b + i);
            hn::Store(to_c, d, c + i);
            hn::Store(to_e, d, e + i);
        }
    }
}

} // namespace
} // namespace afterglow::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace afterglow {
namespace {

HWY_EXPORT(project);
HWY_EXPORT(doubt);
HWY_EXPORT(readings);
HWY_EXPORT(tile_ranges);
HWY_EXPORT(add_parts);

} // namespace

void project_points(const PointRow &points, const RowProjection &projection,
                    const RowMotion &motion, const LandingLimits &limits, int *offsets,
                    WarpedPixel *values) {
    HWY_DYNAMIC_DISPATCH(project)(points, projection, motion, limits, offsets, values);
}

void find_doubtful(const ScatteredRows &scattered, WarpedPixel *out, std::uint8_t *doubtful) {
    HWY_DYNAMIC_DISPATCH(doubt)(scattered, out, doubtful);
}

int find_readings(const WarpedRow &row, std::uint16_t *millimetres, std::uint8_t *edge_distance) {
    return HWY_DYNAMIC_DISPATCH(readings)(row, millimetres, edge_distance);
}

void find_tile_ranges(const PieceRow &pieces, const PieceProjection &projection,
                      TileRange *ranges) {
    HWY_DYNAMIC_DISPATCH(tile_ranges)(pieces, projection, ranges);
}

void add_to_tiles(const SurfacePart *parts, std::span<const TileRange> ranges,
                  ImageView<SurfacePart> tiles) {
    HWY_DYNAMIC_DISPATCH(add_parts)(parts, ranges, tiles);
}

} // namespace afterglow
#endif
