// SPDX-License-Identifier: Apache-2.0
// Compiled once for each instruction set; the best of them is chosen when first called.
#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "core/keyframe/warp_kernels.cpp"
#include "core/keyframe/warp_kernels.hpp"

#include <hwy/foreach_target.h>
#include <hwy/highway.h>

HWY_BEFORE_NAMESPACE();
namespace afterglow::HWY_NAMESPACE {
namespace {

namespace hn = hwy::HWY_NAMESPACE;

/// Steepest slope along which a depth is moved, share of depth per pixel.
constexpr float steepest = 0.03f;

/// Calls work(tag, i) for i in steps of whole vectors, and one by one for the rest.
template <class Work>
void for_lanes(int count, const Work &work) {
    const hn::ScalableTag<float> whole;
    const hn::CappedTag<float, 1> single;
    const int lanes = static_cast<int>(hn::Lanes(whole));
    int i = 0;
    for (; i + lanes <= count; i += lanes)
        work(whole, i);
    for (; i < count; ++i)
        work(single, i);
}

void project(const PointRow &in, const RowProjection &by, const RowMotion &motion,
             const LandingLimits &limits, int *HWY_RESTRICT offsets,
             WarpedPixel *HWY_RESTRICT values) {
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
        const auto in_depth = hn::And(hn::Gt(depth, hn::Set(d, limits.nearest)),
                                      hn::Lt(depth, hn::Set(d, limits.farthest)));
        const auto in_x = hn::And(hn::Ge(x, zero), hn::Lt(x, hn::Set(d, limits.width)));
        const auto in_y = hn::And(hn::Ge(y, zero), hn::Lt(y, hn::Set(d, limits.height)));
        const auto lands =
            hn::And(hn::And(hn::And(hn::Ne(z, zero), carried), in_depth), hn::And(in_x, in_y));
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

} // namespace
} // namespace afterglow::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace afterglow {
namespace {

HWY_EXPORT(project);
HWY_EXPORT(doubt);

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

} // namespace afterglow
#endif
