// SPDX-License-Identifier: Apache-2.0
// Compiled once for each instruction set; the best of them is chosen when first called.
#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "core/surface/surface_kernels.cpp"
#include "core/surface/surface_kernels.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <hwy/foreach_target.h>
#include <hwy/highway.h>

// clang-format off: after Highway, once for each instruction set
#include "core/base/lanes-inl.hpp"
#include "core/surface/sensor_noise-inl.hpp"
#include "core/surface/unit_depths-inl.hpp"
// clang-format on

HWY_BEFORE_NAMESPACE();
namespace afterglow::HWY_NAMESPACE {
namespace {

void load(const ReadingRow &row, const DepthUnits &units, UnitDepth *HWY_RESTRICT z) {
    const ReadingRow in = row; // a copy, which nothing written here can change
    const Units d;
    const hn::RebindToUnsigned<Units> du;
    const int per_millimetre = units.per_millimetre();
    const auto most = hn::Set(du, static_cast<std::uint16_t>(32767 / per_millimetre));
    const auto nearest = hn::Set(d, in.nearest), farthest = hn::Set(d, in.farthest);
    const auto by_row = hn::Set(d, in.by_row);
    const auto block = [&](const std::uint16_t *millimetres,
                           const std::int16_t *by_column) HWY_ATTR {
        const auto whole = hn::BitCast(d, hn::Min(hn::LoadU(du, millimetres), most));
        auto depth = per_millimetre == 2 ? hn::Add(whole, whole) : whole;
        if (by_column != nullptr) {
            const auto share = hn::SaturatedAdd(hn::LoadU(d, by_column), by_row);
            depth = hn::SaturatedAdd(depth, hn::MulFixedPoint15(depth, share));
        }
        const auto outside = hn::Or(hn::Lt(depth, nearest), hn::Gt(depth, farthest));
        return hn::IfThenZeroElse(outside, depth);
    };
    int i = 0;
    for (; i + lanes <= in.count; i += lanes)
        hn::StoreU(block(in.millimetres + i, in.by_column ? in.by_column + i : nullptr), d, z + i);
    if (i < in.count) {
        std::array<std::uint16_t, lanes> rest{};
        std::array<std::int16_t, lanes> by_column{}, depths;
        std::copy(in.millimetres + i, in.millimetres + in.count, rest.begin());
        if (in.by_column != nullptr)
            std::copy(in.by_column + i, in.by_column + in.count, by_column.begin());
        hn::StoreU(block(rest.data(), in.by_column ? by_column.data() : nullptr), d, depths.data());
        std::copy_n(depths.begin(), in.count - i, z + i);
    }
}

void steps(const UnitDepth *HWY_RESTRICT z, int count, float edge_relative,
           const SixSigmaFactors &factors, std::int16_t *HWY_RESTRICT found) {
    const Units d;
    const SixSigmas six_sigmas(factors);
    const auto relative = hn::Set(
        d, static_cast<std::int16_t>(std::lround(std::min(65536 * edge_relative, 32767.0f))));
    for (int i = 0; i < count; i += lanes) {
        const auto depth = hn::LoadU(d, z + i);
        const auto twice =
            hn::SaturatedAdd(hn::MulFixedPoint15(depth, relative), six_sigmas(depth));
        hn::StoreU(hn::IfThenZeroElse(hn::Eq(depth, hn::Zero(d)), twice), d, found + i);
    }
}

void compare(const SteppedRow &row, const SteppedRow &below, int count,
             std::uint8_t *HWY_RESTRICT flags) {
    const SteppedRow here = row, next = below;
    const Units d;
    const hn::Rebind<std::uint8_t, Units> d8;
    const auto zero = hn::Zero(d);
    const auto right = hn::Set(d, parted_from_right), down = hn::Set(d, parted_from_below);
    const auto block = [&](int i) HWY_ATTR {
        const auto z = hn::LoadU(d, here.z + i), step = hn::LoadU(d, here.steps + i);
        const auto parted = [&](const SteppedRow &from, int at) HWY_ATTR {
            const auto difference = hn::Abs(hn::Sub(z, hn::LoadU(d, from.z + at)));
            return hn::VecFromMask(d, hn::Gt(hn::SaturatedAdd(difference, difference),
                                             hn::Min(step, hn::LoadU(d, from.steps + at))));
        };
        const auto found =
            hn::Or(hn::And(parted(here, i + 1), right), hn::And(parted(next, i), down));
        return hn::DemoteTo(d8, hn::IfThenElseZero(hn::Gt(z, zero), found));
    };
    int i = 0;
    for (; i + lanes <= count; i += lanes)
        hn::StoreU(block(i), d8, flags + i);
    if (i < count) {
        std::array<std::uint8_t, lanes> rest;
        hn::StoreU(block(i), d8, rest.data());
        std::copy_n(rest.begin(), count - i, flags + i);
    }
}

Slopes slopes(const UnitDepth *HWY_RESTRICT pixels, const UnitDepth *HWY_RESTRICT next, int count,
              const EdgeRule &of, const DepthUnits &units) {
    // Four, whatever a vector holds: the order of a sum changes its last bits.
    const hn::CappedTag<float, 4> d;
    const hn::RebindToSigned<decltype(d)> di;
    const hn::Rebind<UnitDepth, decltype(d)> d16;
    const SensorNoise noise = in_units(of.noise, units);
    const float relative = of.edge_relative;
    auto sum = hn::Zero(d);
    auto pairs = hn::Zero(di);
    for (int i = 0; i < count; i += static_cast<int>(hn::Lanes(d))) {
        const auto load = [&](const UnitDepth *from) HWY_ATTR {
            return hn::ConvertTo(d, hn::PromoteTo(di, hn::LoadU(d16, from + i)));
        };
        const auto a = load(pixels), b = load(next);
        const auto near = hn::Min(a, b), difference = hn::Abs(hn::Sub(a, b));
        const auto deviation = sigma(d, noise, near);
        const auto step =
            hn::Add(hn::Mul(hn::Set(d, relative), near), hn::Mul(hn::Set(d, 3.0f), deviation));
        const auto exists = hn::Lt(hn::Iota(di, i), hn::Set(di, count));
        const auto both = hn::Gt(order(d, near), hn::Zero(di));
        const auto parted = hn::Gt(order(d, difference), order(d, step));
        const auto alike = hn::AndNot(parted, hn::And(exists, both));
        const auto above = hn::Max(hn::Sub(difference, deviation), hn::Zero(d));
        const auto slope =
            hn::Min(hn::Div(above, hn::Max(near, hn::Set(d, 1.0f))), hn::Set(d, 1.0f));
        sum = hn::Add(sum, hn::IfThenElseZero(hn::RebindMask(d, alike), slope));
        pairs = hn::Sub(pairs, hn::VecFromMask(di, alike));
    }
    return {static_cast<int>(hn::GetLane(hn::SumOfLanes(di, pairs))),
            hn::GetLane(hn::SumOfLanes(d, sum))};
}

void grow(const std::uint8_t *HWY_RESTRICT next, int count, std::uint8_t *HWY_RESTRICT values) {
    for (int i = 0; i < count; ++i) // for the compiler, which makes vector code of it
        values[i] = std::min(values[i], static_cast<std::uint8_t>(next[i] + 1));
}

} // namespace
} // namespace afterglow::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace afterglow {
namespace {

HWY_EXPORT(load);
HWY_EXPORT(steps);
HWY_EXPORT(compare);
HWY_EXPORT(slopes);
HWY_EXPORT(grow);

} // namespace

void load_row(const ReadingRow &in, const DepthUnits &units, UnitDepth *z) {
    HWY_DYNAMIC_DISPATCH(load)(in, units, z);
}

void find_steps(const UnitDepth *z, int count, float edge_relative,
                const SixSigmaFactors &six_sigmas, std::int16_t *found) {
    HWY_DYNAMIC_DISPATCH(steps)(z, count, edge_relative, six_sigmas, found);
}

void compare_neighbours(const SteppedRow &row, const SteppedRow &below, int count,
                        std::uint8_t *flags) {
    HWY_DYNAMIC_DISPATCH(compare)(row, below, count, flags);
}

Slopes find_slopes(const UnitDepth *pixels, const UnitDepth *next, int count, const EdgeRule &rule,
                   const DepthUnits &units) {
    return HWY_DYNAMIC_DISPATCH(slopes)(pixels, next, count, rule, units);
}

void grow_from_row(const std::uint8_t *next, int count, std::uint8_t *values) {
    HWY_DYNAMIC_DISPATCH(grow)(next, count, values);
}

} // namespace afterglow
#endif
