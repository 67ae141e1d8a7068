// SPDX-License-Identifier: Apache-2.0
// Compiled once for each instruction set; the best of them is chosen when first called.
#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "core/keyframe/surface_kernels.cpp"
#include "core/keyframe/surface_kernels.hpp"

#include "core/keyframe/surface_point.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <hwy/foreach_target.h>
#include <hwy/highway.h>
#include <numeric>

// clang-format off: after Highway, once for each instruction set
#include "core/base/lanes-inl.hpp"
#include "core/keyframe/sensor_noise-inl.hpp"
// clang-format on

namespace afterglow {
namespace {
#if !defined(AFTERGLOW_CORE_KEYFRAME_SURFACE_KERNELS_CPP)
#define AFTERGLOW_CORE_KEYFRAME_SURFACE_KERNELS_CPP
/// SensorNoise::sigma() times a factor, of depths in units and in units.
SensorNoise noise_in_units(const SensorNoise &noise, const DepthUnits &units, float factor) {
    return {factor * noise.floor_m * units.per_metre(), factor * noise.linear,
            factor * noise.quadratic_per_m * units.metres(), factor * noise.least_relative};
}
#endif
} // namespace
} // namespace afterglow

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

/// About six times SensorNoise::sigma(), units, of depths in units.
class SixSigmas {
public:
    explicit SixSigmas(const SixSigmaFactors &factors)
        : floor_(hn::Set(Units(), factors.floor)), linear_(hn::Set(Units(), factors.linear)),
          quadratic_(hn::Set(Units(), factors.quadratic)), least_(hn::Set(Units(), factors.least)),
          doublings_(factors.doublings) {}

    template <class V>
    HWY_INLINE V operator()(V z) const {
        const auto curve =
            hn::SaturatedAdd(hn::MulFixedPoint15(z, linear_),
                             hn::MulFixedPoint15(hn::MulFixedPoint15(z, z), quadratic_));
        auto sigmas = hn::Max(hn::SaturatedAdd(floor_, curve), hn::MulFixedPoint15(z, least_));
        for (int i = 0; i < doublings_; ++i)
            sigmas = hn::SaturatedAdd(sigmas, sigmas);
        return sigmas;
    }

private:
    const hn::Vec<Units> floor_, linear_, quadratic_, least_;
    const int doublings_;
};

int load(const ReadingRow &row, const DepthUnits &units, UnitDepth *HWY_RESTRICT z) {
    const ReadingRow in = row; // a copy, which nothing written here can change
    const Units d;
    const hn::RebindToUnsigned<Units> du;
    const int per_millimetre = units.per_millimetre();
    const auto most = hn::Set(du, static_cast<std::uint16_t>(32767 / per_millimetre));
    const auto nearest = hn::Set(d, in.nearest), farthest = hn::Set(d, in.farthest);
    const auto by_row = hn::Set(d, in.by_row);
    auto none = hn::Zero(d); // -1 for each reading left out; a row has fewer than 2^15 vectors
    const auto block = [&](const std::uint16_t *millimetres,
                           const std::int16_t *by_column) HWY_ATTR {
        const auto whole = hn::BitCast(d, hn::Min(hn::LoadU(du, millimetres), most));
        auto depth = per_millimetre == 2 ? hn::Add(whole, whole) : whole;
        if (by_column != nullptr) {
            const auto share = hn::SaturatedAdd(hn::LoadU(d, by_column), by_row);
            depth = hn::SaturatedAdd(depth, hn::MulFixedPoint15(depth, share));
        }
        const auto outside = hn::Or(hn::Lt(depth, nearest), hn::Gt(depth, farthest));
        none = hn::Add(none, hn::VecFromMask(d, outside));
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
        std::copy_n(depths.begin(), in.count - i, z + i); // the rest is nearer than the nearest
        i += lanes;
    }
    std::array<std::int16_t, lanes> of_lanes;
    hn::StoreU(none, d, of_lanes.data());
    return std::accumulate(of_lanes.begin(), of_lanes.end(), i);
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
    const HalfUnits d16;
    const HalfInts di;
    const HalfFloats d;
    const SensorNoise noise = noise_in_units(of.noise, units, 1.0f);
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

/// How far opposite pixels may lie from one that they are averaged with.
template <class V>
struct PairLimits {
    V twice_z;
    V most;  ///< of the sum of both less twice_z, above and below
    V range; ///< between these
};
/// By how much the sum of two opposite depths may differ from twice the one between them.
template <class V>
HWY_API V limit_of(V z, const SixSigmas &six_sigmas) {
    /// Sums of the differences of a row of the largest window stay in 16 bits.
    constexpr int most_pairs = 17;
    const Units d;
    const auto most = hn::Set(d, 32767 / most_pairs);
    const auto tenth_of_z = hn::MulFixedPoint15(z, hn::Set(d, 3277));
    // Never the whole depth: then holes would be readings.
    return hn::Min(hn::Min(six_sigmas(z), hn::Sub(z, tenth_of_z)), most);
}
template <class V>
HWY_API PairLimits<V> pair_limits(V z, const SixSigmas &six_sigmas) {
    const auto limit = limit_of(z, six_sigmas);
    return {hn::Add(z, z), limit, hn::Add(limit, limit)};
}
/// Adds what two opposite pixels differ together from the one between them, if they are on its
/// surface. So a slope does not shift the mean.
template <class V>
HWY_API void add_pair(const PairLimits<V> &limits, V a, V b, V &sum, V &pairs) {
    const Units d;
    const hn::RebindToUnsigned<Units> du;
    const auto difference = hn::Sub(hn::Add(a, b), limits.twice_z);
    // As unsigned numbers differences below the range are beyond it, too.
    const auto above_least = hn::BitCast(du, hn::Add(difference, limits.most));
    const auto near = hn::RebindMask(d, hn::Lt(above_least, hn::BitCast(du, limits.range)));
    const auto ok = hn::And(near, hn::Gt(hn::Min(a, b), hn::Zero(d)));
    sum = hn::Add(sum, hn::IfThenElseZero(ok, difference));
    pairs = hn::Sub(pairs, hn::VecFromMask(d, ok));
}

/// Writes the first `count` lanes of some values.
template <class D, class V>
HWY_API void store(D d, V value, int count, hn::TFromD<D> *HWY_RESTRICT to) {
    constexpr int size = static_cast<int>(hn::MaxLanes(D()));
    if (count >= size) {
        hn::StoreU(value, d, to);
        return;
    }
    std::array<hn::TFromD<D>, size> all;
    hn::StoreU(value, d, all.data());
    std::copy_n(all.begin(), std::max(count, 0), to);
}

/// The first `count` edge distances, pixels, of a vector.
template <class D>
HWY_API hn::Vec<D> load_edges(D d, const std::uint8_t *HWY_RESTRICT from, int count) {
    constexpr int size = static_cast<int>(hn::MaxLanes(D()));
    if (count >= size)
        return hn::LoadU(d, from);
    std::array<std::uint8_t, size> some{};
    std::copy_n(from, count, some.begin());
    return hn::LoadU(d, some.data());
}

void smooth(const SmoothedRow &row, const SixSigmaFactors &factors, const DepthUnits &units,
            float *HWY_RESTRICT out) {
    const SmoothedRow in = row; // a copy, which nothing written here can change
    const Units d;
    const HalfInts di;
    const HalfFloats df;
    const SixSigmas six_sigmas(factors);
    const auto metres = hn::Set(df, units.metres());
    for (int i = 0; i < in.count; i += lanes) {
        const UnitDepth *const at = in.z + i;
        const auto z = hn::LoadU(d, at);
        const auto limits = pair_limits(z, six_sigmas);
        auto sum = hn::Zero(d), pairs = sum;
        auto lower = hn::Zero(di), upper = hn::Zero(di);
        for (int dv = 0; dv <= in.radius; ++dv) {
            for (int du = dv == 0 ? 1 : -in.radius; du <= in.radius; ++du) {
                const std::ptrdiff_t away = dv * in.stride + du;
                add_pair(limits, hn::LoadU(d, at - away), hn::LoadU(d, at + away), sum, pairs);
            }
            lower = hn::Add(lower, hn::PromoteTo(di, lower_half(sum)));
            upper = hn::Add(upper, hn::PromoteTo(di, upper_half(sum)));
            sum = hn::Zero(d);
        }
        // The pixel itself counts as half a pair.
        const auto halves = hn::Add(hn::Add(pairs, pairs), hn::Set(d, 1));
        const auto mean = [&](auto whole, auto differences, auto of) HWY_ATTR {
            const auto shift = hn::Div(hn::ConvertTo(df, differences), of);
            return hn::Mul(hn::Add(whole, shift), metres);
        };
        store(df, mean(lower_floats(z), lower, lower_floats(halves)), in.count - i, out + i);
        store(df, mean(upper_floats(z), upper, upper_floats(halves)), in.count - i - lanes / 2,
              out + i + lanes / 2);
    }
}

using Shifted = hn::RebindToUnsigned<Units>;
/// Depths less one, so that no depth is 2^16 - 1: the mean with another one is then so far from all
/// depths, which are at most DepthUnits::farthest_m, that it counts for none.
template <class V>
HWY_API auto shifted(V z) {
    return hn::BitCast(Shifted(), hn::Sub(z, hn::Set(Units(), 1)));
}
template <class V>
HWY_API auto shifted_back(V z) {
    return hn::BitCast(Units(), hn::Add(z, hn::Set(Shifted(), 1)));
}

/// The means of opposite readings one and two steps away that are on the surface of the one between
/// them: quarters of what they differ together from it, and -1 where both count.
template <class V>
struct TwoMeans {
    V quarters, both;
};
template <class V, class VS, class Load>
HWY_API TwoMeans<V> two_means(V z, VS shifted_z, const SixSigmas &six_sigmas, const Load &load) {
    const Units d;
    const Shifted ds;
    const auto limit = hn::ShiftRight<1>(limit_of(z, six_sigmas)); // of a mean, 3 sigma
    const auto most = hn::BitCast(ds, limit), range = hn::BitCast(ds, hn::Add(limit, limit));
    auto sum = hn::Zero(d), count = sum;
    const auto add = [&](int steps) HWY_ATTR {
        const auto mean = hn::AverageRound(load(-steps), load(steps));
        const auto difference = hn::Sub(mean, shifted_z);
        const auto near =
            hn::BitCast(d, hn::VecFromMask(ds, hn::Lt(hn::Add(difference, most), range)));
        sum = hn::Add(sum, hn::And(near, hn::BitCast(d, difference)));
        count = hn::Sub(count, near);
    };
    add(1);
    add(2);
    // A mean is rounded up by a quarter of a unit on average.
    return {hn::Sub(hn::ShiftLeft<2>(sum), count),
            hn::VecFromMask(d, hn::Gt(count, hn::Set(d, 1)))};
}

void smooth_across(const UnitDepth *HWY_RESTRICT z, int count, const SixSigmaFactors &factors,
                   std::uint16_t *HWY_RESTRICT out) {
    const Units d;
    const SixSigmas six_sigmas(factors);
    const auto sixth = hn::Set(d, 5461), tenth = hn::Set(d, 3277);
    for (int i = 0; i < count; i += lanes) {
        const auto here = hn::LoadU(d, z + i);
        const auto shifted_here = shifted(here);
        const auto [quarters, both] =
            two_means(here, shifted_here, six_sigmas,
                      [&](int steps) HWY_ATTR { return shifted(hn::LoadU(d, z + i + steps)); });
        const auto share = hn::IfThenElse(hn::MaskFromVec(both), tenth, sixth);
        const auto shift = hn::BitCast(Shifted(), hn::MulFixedPoint15(quarters, share));
        store(Shifted(), hn::Add(shifted_here, shift), count - i, out + i);
    }
}

void smooth_down(const std::uint16_t *HWY_RESTRICT z, std::ptrdiff_t stride, int count,
                 const SixSigmaFactors &factors, const DepthUnits &units,
                 const std::uint8_t *HWY_RESTRICT edge_distance, float *HWY_RESTRICT out) {
    const Units d;
    const Shifted ds;
    const HalfInts di;
    const HalfFloats df;
    const hn::Rebind<std::uint8_t, Units> d8;
    const SixSigmas six_sigmas(factors);
    const auto metres = hn::Set(df, units.metres());
    const auto sixth = hn::Set(df, units.metres() / 6), tenth = hn::Set(df, units.metres() / 10);
    const auto edge_bits = hn::Set(di, edge_distance_bits);
    for (int i = 0; i < count; i += lanes) {
        const auto shifted_here = hn::LoadU(ds, z + i);
        const auto here = shifted_back(shifted_here);
        const auto [quarters, both] =
            two_means(here, shifted_here, six_sigmas,
                      [&](int steps) HWY_ATTR { return hn::LoadU(ds, z + i + steps * stride); });
        const auto edges =
            hn::IfThenZeroElse(hn::Eq(here, hn::Zero(d)),
                               hn::PromoteTo(d, load_edges(d8, edge_distance + i, count - i)));
        const auto point = [&](auto whole, auto differences, auto tenths, auto edge) HWY_ATTR {
            const auto ten = hn::RebindMask(df, hn::MaskFromVec(hn::PromoteTo(di, tenths)));
            const auto mean = hn::Add(hn::Mul(whole, metres),
                                      hn::Mul(differences, hn::IfThenElse(ten, tenth, sixth)));
            return hn::BitCast(
                df, hn::Or(hn::AndNot(edge_bits, hn::BitCast(di, mean)), hn::PromoteTo(di, edge)));
        };
        store(
            df,
            point(lower_floats(here), lower_floats(quarters), lower_half(both), lower_half(edges)),
            count - i, out + i);
        store(
            df,
            point(upper_floats(here), upper_floats(quarters), upper_half(both), upper_half(edges)),
            count - i - lanes / 2, out + i + lanes / 2);
    }
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
HWY_EXPORT(smooth_across);
HWY_EXPORT(smooth_down);

} // namespace

SixSigmaFactors::SixSigmaFactors(const SensorNoise &noise, const DepthUnits &units) {
    constexpr int most_doublings = 15;
    const SensorNoise six = noise_in_units(noise, units, 6.0f);
    const float of_square = 32768 * six.quadratic_per_m; // over 2^15
    const float most = std::max(
        {std::abs(six.linear), std::abs(of_square), six.least_relative, six.floor_m / 32768});
    while (std::ldexp(most, -doublings) >= 1 && doublings < most_doublings)
        ++doublings;
    const auto part = [&](float factor) {
        return static_cast<std::int16_t>(
            std::lround(std::clamp(32768 * std::ldexp(factor, -doublings), -32767.0f, 32767.0f)));
    };
    floor = part(six.floor_m / 32768);
    linear = part(six.linear);
    quadratic = part(of_square);
    least = part(six.least_relative);
}

int load_row(const ReadingRow &in, const DepthUnits &units, UnitDepth *z) {
    return HWY_DYNAMIC_DISPATCH(load)(in, units, z);
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

void find_cracks(const InsideRows &inside, int count, std::uint8_t *cracks) {
    HWY_DYNAMIC_DISPATCH(cracks_of_row)(inside, count, cracks);
}

void smooth_row(const SmoothedRow &in, const SixSigmaFactors &six_sigmas, const DepthUnits &units,
                float *out) {
    HWY_DYNAMIC_DISPATCH(smooth)(in, six_sigmas, units, out);
}

void smooth_row_across(const UnitDepth *z, int count, const SixSigmaFactors &six_sigmas,
                       std::uint16_t *out) {
    HWY_DYNAMIC_DISPATCH(smooth_across)(z, count, six_sigmas, out);
}

void smooth_row_down(const std::uint16_t *z, std::ptrdiff_t stride, int count,
                     const SixSigmaFactors &six_sigmas, const DepthUnits &units,
                     const std::uint8_t *edge_distance, float *out) {
    HWY_DYNAMIC_DISPATCH(smooth_down)(z, stride, count, six_sigmas, units, edge_distance, out);
}

} // namespace afterglow
#endif
