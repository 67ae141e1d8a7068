// SPDX-License-Identifier: Apache-2.0
// Compiled once for each instruction set; the best of them is chosen when first called.
#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "core/keyframe/warp_kernels.cpp"
#include "core/keyframe/warp_kernels.hpp"

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

void project(const PointRow &points, const RowProjection &projection, const RowMotion &rows,
             const LandingLimits &landing, int *HWY_RESTRICT offsets,
             WarpedPixel *HWY_RESTRICT values) {
    // Copies, which nothing written here can change.
    const PointRow in = points;
    const RowProjection by = projection;
    const RowMotion motion = rows;
    const LandingLimits limits = landing;
    for_lanes(in.count, [&](auto d, int i) HWY_ATTR {
        const hn::RebindToSigned<decltype(d)> di;
        const hn::Rebind<std::uint8_t, decltype(d)> d8;
        const auto zero = hn::Zero(d);
        const auto half = hn::Set(d, 0.5f);
        const auto left = hn::LoadU(d, in.z + i);
        auto z = hn::LoadU(d, in.z + i + 1);
        const auto right = hn::LoadU(d, in.z + i + 2);
        const auto above = hn::LoadU(d, in.above + i);
        const auto below = hn::LoadU(d, in.below + i);
        const auto edge = hn::PromoteTo(di, hn::LoadU(d8, in.edge_distance + i));
        const auto u = hn::ConvertTo(d, hn::Iota(di, in.first_column + i));
        if (limits.hides_below > 0) {
            const auto hides = hn::And(
                hn::RebindMask(d, hn::Lt(edge, hn::Set(di, limits.hides_below))), hn::Ne(z, zero));
            const auto there = [&](auto at)
                                   HWY_ATTR { return hn::IfThenElse(hn::Eq(at, zero), z, at); };
            const auto nearest =
                hn::Min(hn::Min(there(left), there(right)), hn::Min(there(above), there(below)));
            z = hn::IfThenElse(hides, hn::Min(z, nearest), z);
        }

        const auto along = [&](int k) HWY_ATTR {
            const auto ray =
                hn::Add(hn::Mul(hn::Set(d, by.by_column[k]), u), hn::Set(d, by.origin[k]));
            return hn::Add(hn::Mul(z, ray), hn::Set(d, by.shift[k]));
        };
        auto across = along(0);
        auto down = along(1);
        auto depth = along(2);
        if (motion.any) {
            const auto row = hn::Div(down, depth);
            const auto t =
                hn::Mul(hn::Sub(row, hn::Set(d, motion.middle)), hn::Set(d, motion.per_row));
            const auto part = hn::Min(hn::Max(t, hn::Set(d, -0.5f)), half);
            const auto moved = [&](auto at, int k) HWY_ATTR {
                const auto turned = hn::Add(hn::Mul(hn::Set(d, motion.turn(k, 0)), across),
                                            hn::Add(hn::Mul(hn::Set(d, motion.turn(k, 1)), down),
                                                    hn::Mul(hn::Set(d, motion.turn(k, 2)), depth)));
                return hn::Add(at, hn::Mul(part, hn::Add(turned, hn::Set(d, motion.shift[k]))));
            };
            const auto new_across = moved(across, 0), new_down = moved(down, 1);
            depth = moved(depth, 2);
            across = new_across;
            down = new_down;
        }
        const auto inverse = hn::Div(hn::Set(d, 1.0f), depth);
        const auto x = hn::Add(hn::Mul(across, inverse), half);
        const auto y = hn::Add(hn::Mul(down, inverse), half);
        const auto carried =
            hn::RebindMask(d, hn::Gt(edge, hn::Set(di, limits.least_edge_distance - 1)));
        const auto nothing = hn::Set(di, -1);
        const auto in_depth =
            hn::And(hn::Gt(order(d, depth), order(d, hn::Set(d, limits.nearest))),
                    hn::Lt(order(d, depth), order(d, hn::Set(d, limits.farthest))));
        const auto in_x = hn::And(hn::Gt(order(d, x), nothing),
                                  hn::Lt(order(d, x), order(d, hn::Set(d, limits.width))));
        const auto in_y = hn::And(hn::Gt(order(d, y), nothing),
                                  hn::Lt(order(d, y), order(d, hn::Set(d, limits.height))));
        const auto in_view = hn::RebindMask(d, hn::And(in_depth, hn::And(in_x, in_y)));
        const auto lands = hn::And(hn::And(hn::Ne(z, zero), carried), in_view);
        const auto column = hn::ConvertTo(di, hn::IfThenElseZero(lands, x));
        const auto row = hn::ConvertTo(di, hn::IfThenElseZero(lands, y));

        const auto inside = hn::And(
            hn::And(hn::RebindMask(d, hn::Gt(edge, hn::Set(di, 2))), hn::Ne(left, zero)),
            hn::And(hn::And(hn::Ne(right, zero), hn::Ne(above, zero)), hn::Ne(below, zero)));
        const auto half_inverse_z = hn::Div(half, z);
        const auto slope = [&](auto from, auto to) HWY_ATTR {
            const auto steep = hn::Mul(hn::Sub(to, from), half_inverse_z);
            return hn::Min(hn::Max(steep, hn::Set(d, -steepest)), hn::Set(d, steepest));
        };
        const auto to_centre = [&](auto pixel, auto at) HWY_ATTR {
            return hn::Sub(hn::Add(hn::ConvertTo(d, pixel), half), at);
        };
        const auto rise = hn::Add(hn::Mul(slope(left, right), to_centre(column, x)),
                                  hn::Mul(slope(above, below), to_centre(row, y)));
        const auto moved = hn::IfThenElse(inside, hn::Add(depth, hn::Mul(depth, rise)), depth);
        const auto units = hn::ConvertTo(
            di, hn::Add(hn::Mul(hn::IfThenElseZero(lands, moved), hn::Set(d, warped_units_per_m)),
                        half));
        const auto value = hn::Or(hn::ShiftLeft<warped_depth_shift>(units), edge);
        hn::StoreU(hn::IfThenElse(hn::RebindMask(di, lands), value, hn::Set(di, nothing_landed)),
                   di, values + i);
        hn::StoreU(hn::Add(hn::Mul(row, hn::Set(di, limits.stride)), column), di, offsets + i);
    });
}

void doubt(const ScatteredRows &in, const std::uint16_t *HWY_RESTRICT taken,
           WarpedPixel *HWY_RESTRICT out, std::uint8_t *HWY_RESTRICT doubtful) {
    for_lanes(in.count, [&](auto d, int i) HWY_ATTR {
        const hn::RebindToSigned<decltype(d)> di;
        const hn::Rebind<std::uint8_t, decltype(d)> d8;
        const hn::Rebind<std::uint16_t, decltype(d)> d16;
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
        const auto open = hn::Eq(hn::PromoteTo(di, hn::LoadU(d16, taken + i)), hn::Zero(di));
        const auto mark = hn::IfThenElseZero(hn::And(suspect, open), hn::Set(di, 1));
        hn::StoreU(hn::IfThenZeroElse(empty, here), di, out + i);
        hn::StoreU(hn::DemoteTo(d8, mark), d8, doubtful + i);
    });
}

void readings(const WarpedRow &row, std::uint16_t *HWY_RESTRICT millimetres,
              std::uint16_t *HWY_RESTRICT classes) {
    const WarpedRow in = row; // a copy, which nothing written here can change
    for_lanes(in.count, [&](auto d, int i) HWY_ATTR {
        const hn::RebindToSigned<decltype(d)> di;
        const hn::Rebind<std::uint16_t, decltype(d)> d16;
        const auto set = [&](float value) HWY_ATTR { return hn::Set(d, value); };
        const auto pixel = hn::LoadU(di, in.pixels + i);
        const auto z = hn::Mul(hn::ConvertTo(d, hn::ShiftRight<warped_depth_shift>(pixel)),
                               set(1.0f / warped_units_per_m));
        const auto u = hn::ConvertTo(d, hn::Iota(di, in.first_column + i));
        const auto x = hn::Add(set(in.x0), hn::Mul(set(in.dx), u)), y = set(in.y);
        const auto bend = hn::Mul(set(in.shape[2]), hn::Add(hn::Mul(x, x), hn::Mul(y, y)));
        const auto tilt = hn::Mul(set(in.shape[0]), x);
        const auto scale =
            hn::Add(set(1.0f), hn::Add(tilt, hn::Add(hn::Mul(set(in.shape[1]), y), bend)));
        const auto reading = hn::Div(z, scale);
        const auto whole = hn::ConvertTo(di, hn::Add(hn::Mul(reading, set(1000.0f)), set(0.5f)));
        const auto bin = hn::Min(hn::ConvertTo(di, hn::Mul(reading, set(1.0f / reading_bin_m))),
                                 hn::Set(di, reading_bins - 1));
        const auto edge = hn::And(pixel, hn::Set(di, warped_edge_mask));
        const auto found = hn::Add(hn::Mul(edge, hn::Set(di, reading_bins)), bin);
        hn::StoreU(hn::DemoteTo(d16, whole), d16, millimetres + i);
        hn::StoreU(hn::DemoteTo(d16, found), d16, classes + i);
    });
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

} // namespace

void project_points(const PointRow &points, const RowProjection &projection,
                    const RowMotion &motion, const LandingLimits &limits, int *offsets,
                    WarpedPixel *values) {
    HWY_DYNAMIC_DISPATCH(project)(points, projection, motion, limits, offsets, values);
}

void find_doubtful(const ScatteredRows &scattered, const std::uint16_t *taken, WarpedPixel *out,
                   std::uint8_t *doubtful) {
    HWY_DYNAMIC_DISPATCH(doubt)(scattered, taken, out, doubtful);
}

void find_readings(const WarpedRow &row, std::uint16_t *millimetres, std::uint16_t *classes) {
    HWY_DYNAMIC_DISPATCH(readings)(row, millimetres, classes);
}

} // namespace afterglow
#endif
