// SPDX-License-Identifier: Apache-2.0
// Compiled once for each instruction set; the best of them is chosen when first called.
#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "core/keyframe/surface_kernels.cpp"
#include "core/keyframe/surface_kernels.hpp"

#include <algorithm>
#include <array>
#include <hwy/foreach_target.h>
#include <hwy/highway.h>

// clang-format off: after Highway, once for each instruction set
#include "core/base/lanes-inl.hpp"
#include "core/keyframe/sensor_noise-inl.hpp"
// clang-format on

HWY_BEFORE_NAMESPACE();
namespace afterglow::HWY_NAMESPACE {
namespace {

#if HWY_TARGET == HWY_SCALAR
// One lane, which is both halves.
constexpr int lanes = 1;
using Units = hn::CappedTag<std::int16_t, lanes>;
using HalfUnits = Units;
template <class V>
HWY_API V lower_half(V value) {
    return value;
}
template <class V>
HWY_API V upper_half(V value) {
    return value;
}
template <class V>
HWY_API V combined(V /*upper*/, V lower) {
    return lower;
}
#else
constexpr int lanes = 8;
using Units = hn::CappedTag<std::int16_t, lanes>;
using HalfUnits = hn::Half<Units>;
template <class V>
HWY_API auto lower_half(V value) {
    return hn::LowerHalf(value);
}
template <class V>
HWY_API auto upper_half(V value) {
    return hn::UpperHalf(HalfUnits(), value);
}
template <class V>
HWY_API auto combined(V upper, V lower) {
    return hn::Combine(Units(), upper, lower);
}
#endif
using HalfInts = hn::Rebind<std::int32_t, HalfUnits>;
using HalfFloats = hn::Rebind<float, HalfUnits>;

template <class V>
HWY_API auto lower_floats(V value) {
    return hn::ConvertTo(HalfFloats(), hn::PromoteTo(HalfInts(), lower_half(value)));
}
template <class V>
HWY_API auto upper_floats(V value) {
    return hn::ConvertTo(HalfFloats(), hn::PromoteTo(HalfInts(), upper_half(value)));
}

/// The integers at or below `add` more than some floats, none of which is negative.
template <class V>
HWY_API auto integers(V lower, V upper, float add) {
    const HalfFloats d;
    const auto half = [&](V value) HWY_ATTR {
        return hn::DemoteTo(HalfUnits(),
                            hn::ConvertTo(HalfInts(), hn::Add(value, hn::Set(d, add))));
    };
    return combined(half(upper), half(lower));
}
/// What integers are above exactly if they are above the floats, and below exactly if they are
/// below them.
template <class V>
HWY_API auto upper_limit(V lower, V upper) {
    return integers(lower, upper, 0.0f);
}
template <class V>
HWY_API auto lower_limit(V lower, V upper) {
    return integers(lower, upper, 0.9999f);
}

/// SensorNoise::sigma() times a factor, of depths in units and in units.
SensorNoise in_units(const SensorNoise &noise, const DepthUnits &units, float factor) {
    return {factor * noise.floor_m * units.per_metre(), factor * noise.linear,
            factor * noise.quadratic_per_m * units.metres(), factor * noise.least_relative};
}

int load(const ReadingRow &row, const DepthUnits &units, UnitDepth *HWY_RESTRICT z) {
    const ReadingRow in = row; // a copy, which nothing written here can change
    const Units d;
    const hn::RebindToUnsigned<Units> du;
    const int per_millimetre = units.per_millimetre();
    const auto most = hn::Set(du, static_cast<std::uint16_t>(32767 / per_millimetre));
    const auto nearest = hn::Set(d, in.nearest), farthest = hn::Set(d, in.farthest);
    const auto by_row = hn::Set(d, in.by_row);
    int valid = 0;
    const auto block = [&](const std::uint16_t *millimetres,
                           const std::int16_t *by_column) HWY_ATTR {
        const auto whole = hn::BitCast(d, hn::Min(hn::LoadU(du, millimetres), most));
        auto depth = per_millimetre == 2 ? hn::Add(whole, whole) : whole;
        if (by_column != nullptr) {
            const auto share = hn::SaturatedAdd(hn::LoadU(d, by_column), by_row);
            depth = hn::SaturatedAdd(depth, hn::MulFixedPoint15(depth, share));
        }
        const auto outside = hn::Or(hn::Lt(depth, nearest), hn::Gt(depth, farthest));
        valid += lanes - static_cast<int>(hn::CountTrue(d, outside));
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
        // Readings of 0 are nearer than the nearest.
        std::copy_n(depths.begin(), in.count - i, z + i);
    }
    return valid;
}

void steps(const UnitDepth *HWY_RESTRICT z, int count, const EdgeRule &of, const DepthUnits &units,
           std::int16_t *HWY_RESTRICT found) {
    const Units d;
    const SensorNoise noise = in_units(of.noise, units, 6.0f);
    const float relative = 2.0f * of.edge_relative;
    const HalfFloats df;
    const auto step = [&](auto depth) HWY_ATTR {
        return hn::Add(hn::Mul(hn::Set(df, relative), depth), sigma(df, noise, depth));
    };
    for (int i = 0; i < count; i += lanes) {
        const auto depth = hn::LoadU(d, z + i);
        const auto twice = upper_limit(step(lower_floats(depth)), step(upper_floats(depth)));
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
    const HalfUnits d16;
    const HalfInts di;
    const HalfFloats d;
    const SensorNoise noise = in_units(of.noise, units, 1.0f);
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

/// `fixed_radius`: the radius, if it is known when this is compiled, else 0.
template <int fixed_radius, int step>
HWY_API void smooth_by(const SmoothedRow &in, const SensorNoise &sensor, const DepthUnits &units,
                       float *HWY_RESTRICT out) {
    /// So many differences may be added up in 16 bits.
    constexpr int most_pairs = 17;
    constexpr int most_unit_pairs = fixed_radius == 2 ? 12 : most_pairs;
    const Units d;
    const HalfInts di;
    const HalfFloats df;
    const int most_steps = (fixed_radius > 0 ? fixed_radius : in.radius) / step;
    const UnitDepth *const from = in.z;
    const std::ptrdiff_t stride = in.stride;
    const int count = in.count;
    const float metres = units.metres();
    const SensorNoise noise = in_units(sensor, units, 6.0f);
    const auto zero = hn::Zero(d);
    const auto tenth = hn::Set(d, 3277), most = hn::Set(d, 32767 / most_unit_pairs);
    for (int i = 0; i < count; i += lanes) {
        const auto z = hn::LoadU(d, from + i);
        const auto tenth_of_z = hn::MulFixedPoint15(z, tenth);
        const auto six_sigmas =
            lower_limit(sigma(df, noise, lower_floats(z)), sigma(df, noise, upper_floats(z)));
        // Never the whole depth: then holes would be readings.
        const auto limit = hn::Min(hn::Min(six_sigmas, hn::Sub(z, tenth_of_z)), most);
        const auto pair_limit = hn::Add(limit, tenth_of_z);
        const auto twice_z = hn::Add(z, z);
        auto sum = zero, pairs = zero;
        auto lower = hn::Zero(di), upper = hn::Zero(di);
        const auto flush = [&]() HWY_ATTR {
            lower = hn::Add(lower, hn::PromoteTo(di, lower_half(sum)));
            upper = hn::Add(upper, hn::PromoteTo(di, upper_half(sum)));
            sum = zero;
        };
        int unflushed = 0;
        // Opposite pixels enter as pairs, so that a slope does not shift the mean.
        for (int dv = 0; dv <= most_steps; ++dv) {
            const UnitDepth *above = from + i - dv * step * stride;
            const UnitDepth *below = from + i + dv * step * stride;
            const int row_pairs = dv == 0 ? most_steps : 2 * most_steps + 1;
            if (unflushed + row_pairs > most_unit_pairs) {
                flush();
                unflushed = 0;
            }
            unflushed += row_pairs;
            for (int du = dv == 0 ? 1 : -most_steps; du <= most_steps; ++du) {
                const auto a = hn::LoadU(d, above - du * step);
                const auto b = hn::LoadU(d, below + du * step);
                const auto difference = hn::Sub(hn::Add(a, b), twice_z);
                const auto ok = hn::And(hn::Lt(hn::Abs(difference), limit),
                                        hn::Lt(hn::Abs(hn::Sub(a, b)), pair_limit));
                sum = hn::Add(sum, hn::IfThenElseZero(ok, difference));
                pairs = hn::Sub(pairs, hn::VecFromMask(d, ok));
            }
        }
        flush();
        // The pixel itself counts as half a pair.
        const auto halves = hn::Add(hn::Add(pairs, pairs), hn::Set(d, 1));
        const auto mean = [&](auto whole, auto differences, auto of) HWY_ATTR {
            const auto shift = hn::Div(hn::ConvertTo(df, differences), of);
            return hn::Mul(hn::Add(whole, shift), hn::Set(df, metres));
        };
        const auto first = mean(lower_floats(z), lower, lower_floats(halves));
        const auto second = mean(upper_floats(z), upper, upper_floats(halves));
        if (i + lanes <= count) {
            hn::StoreU(first, df, out + i);
            hn::StoreU(second, df, out + i + lanes / 2);
        } else {
            std::array<float, lanes> rest;
            hn::StoreU(first, df, rest.data());
            hn::StoreU(second, df, rest.data() + lanes / 2);
            std::copy_n(rest.begin(), count - i, out + i);
        }
    }
}

void smooth(const SmoothedRow &in, const SensorNoise &noise, const DepthUnits &units, float *out) {
    const auto smooth_it = in.every_second  ? in.radius == 2 ? smooth_by<2, 2> : smooth_by<0, 2>
                            : in.radius == 2 ? smooth_by<2, 1>
                                            : smooth_by<0, 1>;
    smooth_it(in, noise, units, out);
}

void cracks_of_row(const InsideRows &rows, int count, std::uint8_t *HWY_RESTRICT cracks) {
    const InsideRows in = rows; // a copy, which nothing written here can change
    const hn::CappedTag<std::uint8_t, 16> d;
    for_overlapping_lanes(d, count, [&](auto d8, int i) HWY_ATTR {
        const auto at = [&](const std::uint8_t *row, int u)
                            HWY_ATTR { return hn::LoadU(d8, row + i + u); };
        const auto between = [&](auto before2, auto before, auto after, auto after2) HWY_ATTR {
            return hn::Or(hn::And(before, hn::Or(after, after2)), hn::And(before2, after));
        };
        const auto across = between(at(in.row, -2), at(in.row, -1), at(in.row, 1), at(in.row, 2));
        const auto down =
            between(at(in.above2, 0), at(in.above, 0), at(in.below, 0), at(in.below2, 0));
        const auto falling =
            between(at(in.above2, -2), at(in.above, -1), at(in.below, 1), at(in.below2, 2));
        const auto rising =
            between(at(in.above2, 2), at(in.above, 1), at(in.below, -1), at(in.below2, -2));
        const auto any = hn::Or(hn::Or(across, down), hn::Or(falling, rising));
        hn::StoreU(hn::AndNot(at(in.row, 0), any), d8, cracks + i);
    });
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
HWY_EXPORT(cracks_of_row);
HWY_EXPORT(smooth);

} // namespace

int load_row(const ReadingRow &in, const DepthUnits &units, UnitDepth *z) {
    return HWY_DYNAMIC_DISPATCH(load)(in, units, z);
}

void find_steps(const UnitDepth *z, int count, const EdgeRule &rule, const DepthUnits &units,
                std::int16_t *found) {
    HWY_DYNAMIC_DISPATCH(steps)(z, count, rule, units, found);
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

void find_cracks(const InsideRows &inside, int count, std::uint8_t *cracks) {
    HWY_DYNAMIC_DISPATCH(cracks_of_row)(inside, count, cracks);
}

void smooth_row(const SmoothedRow &in, const SensorNoise &noise, const DepthUnits &units,
                float *out) {
    HWY_DYNAMIC_DISPATCH(smooth)(in, noise, units, out);
}

} // namespace afterglow
#endif
