// SPDX-License-Identifier: Apache-2.0
// Compiled once for each instruction set; the best of them is chosen when first called.
#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "core/surface/smoothing_kernels.cpp"
#include "core/surface/smoothing_kernels.hpp"

#include "core/surface/surface_point.hpp"

#include <algorithm>
#include <array>
#include <cassert>
#include <cstddef>
#include <cstdint>
#include <hwy/foreach_target.h>
#include <hwy/highway.h>

// clang-format off: after Highway, once for each instruction set
#include "core/base/lanes-inl.hpp"
#include "core/surface/unit_depths-inl.hpp"
// clang-format on

HWY_BEFORE_NAMESPACE();
namespace afterglow::HWY_NAMESPACE {
namespace {

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

/// Of the opposite readings one and two steps away from a reading z, those whose mean is within a
/// limit of z: the sum of (mean - z), quarters of a unit, and -1 where both pairs count. The mean
/// of z and of n such pairs is z + 2 / (2 n + 1) times the sum: a sixth of the quarters for one
/// pair, a tenth for two.
template <class V>
struct TwoMeans {
    V quarters, both;
};
template <class V, class VS, class Load>
HWY_API TwoMeans<V> two_means(VS shifted_z, V limit, const Load &load) {
    const Units d;
    const Shifted ds;
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

/// The mean of z and of the pairs that count.
template <class V, class VS>
HWY_API VS mean_of(VS shifted_z, const TwoMeans<V> &means) {
    const Units d;
    const auto sixth = hn::Set(d, 5461), tenth = hn::Set(d, 3277);
    const auto share = hn::IfThenElse(hn::MaskFromVec(means.both), tenth, sixth);
    return hn::Add(shifted_z, hn::BitCast(Shifted(), hn::MulFixedPoint15(means.quarters, share)));
}

void smooth_across(const UnitDepth *HWY_RESTRICT z, int count, const SixSigmaFactors &factors,
                   std::uint16_t *HWY_RESTRICT out, UnitDepth *HWY_RESTRICT limits) {
    const SixSigmas six_sigmas(factors);
    for_overlapping_vectors(lanes, count, [&](int i) HWY_ATTR {
        const Units d;
        const auto here = hn::LoadU(d, z + i);
        const auto shifted_here = shifted(here);
        const auto limit = hn::ShiftRight<1>(limit_of(here, six_sigmas));
        const auto means = two_means(shifted_here, limit, [&](int steps) HWY_ATTR {
            return shifted(hn::LoadU(d, z + i + steps));
        });
        hn::StoreU(mean_of(shifted_here, means), Shifted(), out + i);
        hn::StoreU(limit, d, limits + i);
    });
}

void smooth_down(const ReadingsAcross &rows, int count, const DepthUnits &units,
                 const std::uint8_t *HWY_RESTRICT edge_distance, float *HWY_RESTRICT out) {
    const ReadingsAcross in = rows; // a copy, which nothing written here can change
    const Shifted ds;
    const HalfInts di;
    const HalfFloats df;
    const hn::Rebind<std::uint8_t, Units> d8;
    const auto metres = hn::Set(df, units.metres());
    const auto edge_bits = hn::Set(di, edge_distance_bits);
    for_overlapping_vectors(lanes, count, [&](int i) HWY_ATTR {
        const Units d;
        const auto shifted_here = hn::LoadU(ds, in.z + i);
        const auto means =
            two_means(shifted_here, hn::LoadU(d, in.limits + i), [&](int steps) HWY_ATTR {
                return hn::LoadU(ds, in.z + i + steps * in.stride);
            });
        const auto mean = shifted_back(mean_of(shifted_here, means));
        const auto edges = hn::IfThenZeroElse(hn::Eq(mean, hn::Zero(d)),
                                              hn::PromoteTo(d, hn::LoadU(d8, edge_distance + i)));
        const auto point = [&](auto whole, auto edge) HWY_ATTR {
            const auto z_bits = hn::BitCast(di, hn::Mul(whole, metres));
            return hn::BitCast(df, hn::Or(hn::AndNot(edge_bits, z_bits), hn::PromoteTo(di, edge)));
        };
        hn::StoreU(point(lower_floats(mean), lower_half(edges)), df, out + i);
        hn::StoreU(point(upper_floats(mean), upper_half(edges)), df, out + i + lanes / 2);
    });
}

} // namespace
} // namespace afterglow::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace afterglow {
namespace {

HWY_EXPORT(smooth);
HWY_EXPORT(smooth_across);
HWY_EXPORT(smooth_down);

} // namespace

void smooth_row(const SmoothedRow &in, const SixSigmaFactors &six_sigmas, const DepthUnits &units,
                float *out) {
    HWY_DYNAMIC_DISPATCH(smooth)(in, six_sigmas, units, out);
}

void smooth_row_across(const UnitDepth *z, int count, const SixSigmaFactors &six_sigmas,
                       std::uint16_t *out, UnitDepth *limits) {
    assert(count >= least_of_pass);
    HWY_DYNAMIC_DISPATCH(smooth_across)(z, count, six_sigmas, out, limits);
}

void smooth_row_down(const ReadingsAcross &in, int count, const DepthUnits &units,
                     const std::uint8_t *edge_distance, float *out) {
    assert(count >= least_of_pass);
    HWY_DYNAMIC_DISPATCH(smooth_down)(in, count, units, edge_distance, out);
}

} // namespace afterglow
#endif
