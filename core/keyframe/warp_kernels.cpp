// SPDX-License-Identifier: Apache-2.0
// Compiled once for each instruction set; the best of them is chosen when first called.
#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "core/keyframe/warp_kernels.cpp"
#include "core/keyframe/warp_kernels.hpp"

#include "core/keyframe/surface_point.hpp"

#include <algorithm>
#include <array>
#include <cstring>
#include <hwy/foreach_target.h>
#include <hwy/highway.h>

// clang-format off: after Highway, once for each instruction set
#include "core/base/lanes-inl.hpp"
// clang-format on

HWY_BEFORE_NAMESPACE();
namespace afterglow::HWY_NAMESPACE {
namespace {

/// Steepest slope along which a depth is moved, share of depth per pixel.
constexpr float steepest = 0.03f;

constexpr std::array<float, 64> whole_numbers = [] {
    std::array<float, 64> numbers{};
    for (std::size_t i = 0; i < numbers.size(); ++i)
        numbers[i] = static_cast<float>(i);
    return numbers;
}();

/// first, first + 1, ...; as a table, since g++ makes it number by number.
template <class D>
HWY_API auto ramp(D d, int first) {
    return hn::Add(hn::LoadU(d, whole_numbers.data()), hn::Set(d, static_cast<float>(first)));
}

/// Edge distances of points of a surface, 0 where there is none.
template <class D, class V>
HWY_API auto edge_of(D /*tag*/, V z) {
    const hn::RebindToSigned<D> di;
    return hn::And(hn::BitCast(di, z), hn::Set(di, edge_distance_bits));
}

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
        const auto column = hn::ConvertTo(di, hn::IfThenElseZero(hn::RebindMask(d, lands), x));
        const auto row = hn::ConvertTo(di, hn::IfThenElseZero(hn::RebindMask(d, lands), y));

        // Inside the surface the depth changes from pixel to pixel as between the neighbours.
        const auto left = hn::LoadU(d, in.z + i), right = hn::LoadU(d, in.z + i + 2);
        const auto above = hn::LoadU(d, in.above + i), below = hn::LoadU(d, in.below + i);
        const auto least =
            hn::Min(hn::Min(bits(left), bits(right)), hn::Min(bits(above), bits(below)));
        const auto inside =
            hn::And(hn::Gt(edge, hn::Set(di, 2)), hn::RebindMask(di, hn::Ne(least, hn::Zero(du))));
        const auto most = hn::Mul(hn::Set(d, steepest), depth);
        const auto least_step = hn::Mul(hn::Set(d, -steepest), depth); // Neg() is slow on ARMv7
        const auto slope = [&](auto from, auto to) HWY_ATTR {
            const auto step = hn::Mul(half, hn::Sub(to, from));
            return hn::Min(hn::Max(step, least_step), most);
        };
        const auto to_centre = [&](auto pixel, auto place) HWY_ATTR {
            return hn::Sub(hn::ConvertTo(d, pixel), hn::Sub(place, half));
        };
        const auto rise = hn::Add(hn::Mul(slope(left, right), to_centre(column, x)),
                                  hn::Mul(slope(above, below), to_centre(row, y)));
        const auto moved = hn::Add(depth, hn::IfThenElseZero(hn::RebindMask(d, inside), rise));
        const auto units =
            hn::ConvertTo(di, hn::Add(hn::Mul(moved, hn::Set(d, warped_units_per_m)), half));
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
        const auto whole = hn::ConvertTo(di, hn::Add(hn::Mul(units, factor), hn::Set(d, 0.5f)));
        const auto edge = hn::And(pixel, hn::Set(di, warped_edge_mask));
        hn::StoreU(hn::DemoteTo(d16, whole), d16, millimetres + i);
        hn::StoreU(hn::DemoteTo(d8, edge), d8, edges + i);
        found += static_cast<int>(hn::CountTrue(di, hn::Gt(pixel, hn::Zero(di))));
    });
    return found;
}

void tile_ranges(const PieceRow &pieces, const PieceProjection &projection,
                 TileRange *HWY_RESTRICT ranges, TileRange *HWY_RESTRICT wide_ranges) {
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
            // As SurfaceProjection::jacobian().
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
            return hn::Sub(hn::ConvertTo(di, inside), hn::Set(di, 1));
        };
        const auto store = [&](float margin, TileRange *to) HWY_ATTR {
            const auto first = [&](V place, int count) HWY_ATTR {
                const auto reached = hn::IfThenElseZero(all, hn::Sub(place, set(margin)));
                return hn::DemoteTo(d16, hn::Max(tile(reached, count), hn::Zero(di)));
            };
            const auto last = [&](V place, int count) HWY_ATTR {
                const auto reached =
                    hn::IfThenElse(all, hn::Add(place, set(margin)), set(beyond_all));
                const auto most = hn::Min(tile(reached, count), hn::Set(di, count - 1));
                return hn::DemoteTo(d16, hn::IfThenElse(seen, most, hn::Set(di, -1)));
            };
            hn::StoreInterleaved4(first(left, by.columns), last(right, by.columns),
                                  first(top, by.lines), last(bottom, by.lines), d16, &to->left);
        };
        store(by.margin, ranges + i);
        store(by.wide_margin, wide_ranges + i);
    });
}

/// A value that is bilinear between a tile's corners, in columns of vectors: at the first row, and
/// the step to the next one.
template <class V>
struct Bilinear {
    V value, step;
};

/// How much the depth changes from a point of a surface to another place on it, which is `along`
/// and `down` from there, pixels: as between the points around, if they are of that surface, too.
template <class D, class V, class VI>
HWY_API V rise_between(D d, ImageView<const float> z, VI column, VI line, V depth, V along,
                       V down) {
    const hn::RebindToSigned<D> di;
    const hn::RebindToUnsigned<D> du;
    const auto stride = hn::Set(di, z.stride()), one = hn::Set(di, 1);
    const auto within = [&](VI at, int size) HWY_ATTR {
        const auto last = hn::Set(du, static_cast<std::uint32_t>(size - 2));
        return hn::RebindMask(di, hn::Lt(hn::BitCast(du, hn::Sub(at, one)), last));
    };
    const auto has_neighbours = hn::And(within(column, z.width()), within(line, z.height()));
    const auto offset = hn::IfThenElse(has_neighbours, hn::Add(hn::Mul(line, stride), column),
                                       hn::Add(stride, one));
    const auto at = [&](VI place) HWY_ATTR { return hn::GatherIndex(d, z.data(), place); };
    const auto left = at(hn::Sub(offset, one)), right = at(hn::Add(offset, one));
    const auto above = at(hn::Sub(offset, stride)), below = at(hn::Add(offset, stride));
    const auto bits = [&](V value) HWY_ATTR { return hn::BitCast(du, value); };
    const auto least = hn::Min(hn::Min(bits(left), bits(right)), hn::Min(bits(above), bits(below)));
    const auto inside = hn::And(hn::And(has_neighbours, hn::Gt(edge_of(d, depth), hn::Set(di, 2))),
                                hn::RebindMask(di, hn::Ne(least, hn::Zero(du))));
    const auto most = hn::Mul(hn::Set(d, steepest), depth);
    const auto least_step = hn::Mul(hn::Set(d, -steepest), depth);
    const auto slope = [&](V from, V to) HWY_ATTR {
        const auto step = hn::Mul(hn::Set(d, 0.5f), hn::Sub(to, from));
        return hn::Min(hn::Max(step, least_step), most);
    };
    const auto rise =
        hn::Add(hn::Mul(slope(left, right), along), hn::Mul(slope(above, below), down));
    return hn::IfThenElseZero(hn::RebindMask(d, inside), rise);
}

/// How much the depth of a tile's surface changes from column to column and from row to row of it.
struct TileSlope {
    float by_u = 0, by_v = 0;
};
/// The slope along both diagonals tells it.
TileSlope slope_between(const MappedTile &tile) {
    const MappedCorner &a = tile.corners[0], &b = tile.corners[1];
    const MappedCorner &c = tile.corners[2], &e = tile.corners[3];
    const float u1 = e.u - a.u, v1 = e.v - a.v, z1 = e.z - a.z;
    const float u2 = c.u - b.u, v2 = c.v - b.v, z2 = c.z - b.z;
    const float area = u1 * v2 - u2 * v1, most = steepest * a.z;
    return {std::clamp((z1 * v2 - z2 * v1) / area, -most, most),
            std::clamp((u1 * z2 - u2 * z1) / area, -most, most)};
}

/// Pixels of a tile, each so many from the next, whose readings tell those between them.
constexpr int grid_px = 4, grid_across = mapped_tile_px / grid_px + 1;
/// All of them and some more, as whole vectors have: where they are, shares of the tile.
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

/// The readings at the grid's pixels, and half a unit; false if one of them is not far from edges.
bool read_grid(const MappedTile &tile, ImageView<const float> z, float *HWY_RESTRICT readings) {
    const hn::CappedTag<float, grid_pixels> d;
    const hn::RebindToSigned<decltype(d)> di;
    const MappedCorner &a = tile.corners[0], &b = tile.corners[1];
    const MappedCorner &c = tile.corners[2], &e = tile.corners[3];
    const auto [by_u, by_v] = slope_between(tile);
    const auto half = hn::Set(d, 0.5f);
    const auto far = hn::Set(di, edge_distance_bits);
    auto edges = far;
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
        const auto rise = hn::Add(hn::Mul(hn::Set(d, by_u), hn::Sub(u, hn::ConvertTo(d, column))),
                                  hn::Mul(hn::Set(d, by_v), hn::Sub(v, hn::ConvertTo(d, row))));
        const auto reading = hn::Add(hn::Mul(hn::Add(depth, rise), between(&MappedCorner::scale)),
                                     between(&MappedCorner::shift));
        hn::Store(hn::Add(reading, half), d, readings + i);
    }
    return hn::AllTrue(di, hn::Eq(edges, far));
}

/// A tile between the readings of its grid.
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
        std::memset(edge_distance.row(row), edge_distance_bits, mapped_tile_px);
    return mapped_tile_px * mapped_tile_px;
}

template <bool in_picture, bool sloped>
int draw_tile(const MappedTile &tile, ImageView<const float> z, int least_edge_distance,
              ImageView<std::uint16_t> millimetres, ImageView<std::uint8_t> edge_distance) {
    const hn::CappedTag<float, mapped_tile_px> d;
    const hn::RebindToSigned<decltype(d)> di;
    const hn::Rebind<std::uint16_t, decltype(d)> d16;
    const hn::Rebind<std::uint8_t, decltype(d)> d8;
    constexpr float part = 1.0f / mapped_tile_px;
    const MappedCorner &a = tile.corners[0], &b = tile.corners[1];
    const MappedCorner &c = tile.corners[2], &e = tile.corners[3];
    const auto [by_u, by_v] = sloped ? slope_between(tile) : TileSlope{};
    const auto across = hn::Set(d, by_u), down = hn::Set(d, by_v);
    const auto below_least = hn::Set(di, least_edge_distance - 1);
    const float *const depths = z.data();
    const auto depth_stride = hn::Set(di, z.stride());
    [[maybe_unused]] const auto half = hn::Set(d, 0.5f);
    [[maybe_unused]] const auto inverse_depth = hn::Set(d, tile.inverse_depth);
    auto found = hn::Zero(di);
    for (int i = 0; i < mapped_tile_px; i += static_cast<int>(hn::Lanes(d))) {
        const auto column = ramp(d, i);
        const auto between = [&](float at_a, float at_b, float at_c, float at_e) HWY_ATTR {
            const float step = part * (at_b - at_a);
            const auto first = hn::Add(hn::Set(d, at_a), hn::Mul(column, hn::Set(d, step)));
            const auto of_step = hn::Set(d, part * (part * (at_e - at_c) - step));
            return Bilinear<hn::Vec<decltype(d)>>{
                first, hn::Add(hn::Set(d, part * (at_c - at_a)), hn::Mul(column, of_step))};
        };
        // Places are half a pixel more, so that what is below is the nearest pixel.
        auto u = between(a.u + 0.5f, b.u + 0.5f, c.u + 0.5f, e.u + 0.5f);
        auto v = between(a.v + 0.5f, b.v + 0.5f, c.v + 0.5f, e.v + 0.5f);
        auto scale = between(a.scale, b.scale, c.scale, e.scale);
        const auto shifted = [slope = by_u + by_v](const MappedCorner &corner) {
            return corner.shift - 0.5f * slope * corner.scale + 0.5f;
        };
        auto shift = between(shifted(a), shifted(b), shifted(c), shifted(e));
        for (int row = 0; row < mapped_tile_px; ++row) {
            const auto x = hn::ConvertTo(di, u.value), y = hn::ConvertTo(di, v.value);
            auto offset = hn::Add(hn::Mul(y, depth_stride), x);
            hn::Mask<decltype(di)> on_picture;
            if constexpr (!in_picture) {
                const hn::RebindToUnsigned<decltype(d)> du;
                const auto inside = [&](auto at, int end) HWY_ATTR {
                    return hn::RebindMask(di, hn::Lt(hn::BitCast(du, at),
                                                     hn::Set(du, static_cast<std::uint32_t>(end))));
                };
                on_picture = hn::And(inside(x, z.width()), inside(y, z.height()));
                offset = hn::IfThenElseZero(on_picture, offset);
            }
            const auto depth = hn::GatherIndex(d, depths, offset);
            const auto along = hn::Sub(u.value, hn::ConvertTo(d, x));
            const auto downwards = hn::Sub(v.value, hn::ConvertTo(d, y));
            hn::Vec<decltype(d)> rise;
            if constexpr (sloped)
                rise = hn::Add(hn::Mul(across, along), hn::Mul(down, downwards));
            else {
                const auto nearer = hn::Sub(hn::Div(hn::Set(d, 1.0f), depth), inverse_depth);
                rise = rise_between(
                    d, z, x, y, depth,
                    hn::Sub(hn::Sub(along, half), hn::Mul(hn::Set(d, tile.parallax_u), nearer)),
                    hn::Sub(hn::Sub(downwards, half),
                            hn::Mul(hn::Set(d, tile.parallax_v), nearer)));
            }
            const auto reading = hn::Add(hn::Mul(hn::Add(depth, rise), scale.value), shift.value);
            const auto edge = edge_of(d, depth);
            auto there = hn::Gt(edge, below_least);
            if constexpr (!in_picture)
                there = hn::And(there, on_picture);
            const auto whole = hn::IfThenElseZero(there, hn::ConvertTo(di, reading));
            found = hn::Sub(found, hn::VecFromMask(di, there));
            hn::StoreU(hn::DemoteTo(d16, whole), d16, millimetres.row(row) + i);
            hn::StoreU(hn::DemoteTo(d8, hn::IfThenElseZero(there, edge)), d8,
                       edge_distance.row(row) + i);
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
    const auto draw_it = tile.in_picture
                             ? tile.sloped ? draw_tile<true, true> : draw_tile<true, false>
                         : tile.sloped ? draw_tile<false, true>
                                       : draw_tile<false, false>;
    return draw_it(tile, z, least_edge_distance, millimetres, edge_distance);
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
HWY_EXPORT(draw);

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

void find_tile_ranges(const PieceRow &pieces, const PieceProjection &projection, TileRange *ranges,
                      TileRange *wide_ranges) {
    HWY_DYNAMIC_DISPATCH(tile_ranges)(pieces, projection, ranges, wide_ranges);
}

int draw_mapped(const MappedTile &tile, ImageView<const float> z, int least_edge_distance,
                ImageView<std::uint16_t> millimetres, ImageView<std::uint8_t> edge_distance) {
    return HWY_DYNAMIC_DISPATCH(draw)(tile, z, least_edge_distance, millimetres, edge_distance);
}

} // namespace afterglow
#endif
