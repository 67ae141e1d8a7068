// SPDX-License-Identifier: Apache-2.0
// Compiled once for each instruction set; the best of them is chosen when first called.
#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "core/keyframe/surface_kernels.cpp"
#include "core/keyframe/surface_kernels.hpp"

#include <algorithm>
#include <hwy/foreach_target.h>
#include <hwy/highway.h>

// clang-format off: after Highway, once for each instruction set
#include "core/base/lanes-inl.hpp"
// clang-format on

HWY_BEFORE_NAMESPACE();
namespace afterglow::HWY_NAMESPACE {
namespace {

/// SensorNoise::sigma() of each depth.
template <class D, class V>
HWY_API V sigma(D d, const SensorNoise &noise, V z) {
    const auto curve =
        hn::Add(hn::Set(d, noise.linear), hn::Mul(z, hn::Set(d, noise.quadratic_per_m)));
    return hn::Max(hn::Add(hn::Set(d, noise.floor_m), hn::Mul(z, curve)),
                   hn::Mul(hn::Set(d, noise.least_relative), z));
}

void smooth(const SmoothedRow &row, const SensorNoise &sensor, float *HWY_RESTRICT out) {
    // Copies, which nothing written here can change.
    const SmoothedRow in = row;
    const SensorNoise noise = sensor;
    for_lanes(in.count, [&](auto d, int i) HWY_ATTR {
        const auto set = [&](float value) HWY_ATTR { return hn::Set(d, value); };
        const auto zero = hn::Zero(d), half = set(0.5f), one = set(1.0f);
        const auto z = hn::LoadU(d, in.z + i);
        const auto limit = hn::Mul(set(3.0f), sigma(d, noise, z));
        const auto limit_order = order(d, limit);
        const auto pair_limit_order =
            order(d, hn::Add(hn::Mul(set(2.0f), limit), hn::Mul(set(0.1f), z)));
        auto sum = zero, total = half;
        // Opposite pixels enter as pairs, so that a slope does not shift the mean.
        for (int dv = 0; dv <= in.radius; ++dv) {
            const float *above = in.z + i - dv * in.stride;
            const float *below = in.z + i + dv * in.stride;
            for (int du = dv == 0 ? 1 : -in.radius; du <= in.radius; ++du) {
                const auto a = hn::LoadU(d, above - du), b = hn::LoadU(d, below + du);
                const auto mean = hn::Mul(half, hn::Add(a, b));
                const auto near =
                    hn::And(hn::Lt(order(d, hn::Abs(hn::Sub(mean, z))), limit_order),
                            hn::Lt(order(d, hn::Abs(hn::Sub(a, b))), pair_limit_order));
                const auto missing = hn::Or(hn::Eq(a, zero), hn::Eq(b, zero));
                const auto ok = hn::AndNot(missing, hn::RebindMask(d, near));
                sum = hn::Add(sum, hn::IfThenElseZero(ok, mean));
                total = hn::Add(total, hn::IfThenElseZero(ok, one));
            }
        }
        // The pixel itself counts as half a pair.
        const auto mean = hn::Div(hn::Add(hn::Mul(half, z), sum), total);
        hn::StoreU(hn::IfThenZeroElse(hn::Eq(z, zero), mean), d, out + i);
    });
}

int load(const ReadingRow &row, float *HWY_RESTRICT z) {
    const ReadingRow in = row; // a copy, which nothing written here can change
    int valid = 0;
    for_lanes(in.count, [&](auto d, int i) HWY_ATTR {
        const hn::RebindToSigned<decltype(d)> di;
        const hn::Rebind<std::uint16_t, decltype(d)> d16;
        const auto set = [&](float value) HWY_ATTR { return hn::Set(d, value); };
        const auto whole = hn::PromoteTo(di, hn::LoadU(d16, in.millimetres + i));
        const auto x = hn::Add(set(in.x0), hn::Mul(set(in.dx), hn::ConvertTo(d, hn::Iota(di, i))));
        const auto bend = hn::Mul(set(in.shape[2]), hn::Add(hn::Mul(x, x), set(in.y * in.y)));
        const auto tilt = hn::Mul(set(in.shape[0]), x);
        const auto scale =
            hn::Add(set(1.0f), hn::Add(tilt, hn::Add(set(in.shape[1] * in.y), bend)));
        const auto depth = hn::Mul(hn::Mul(set(0.001f), hn::ConvertTo(d, whole)), scale);
        const auto outside = hn::Or(hn::Lt(order(d, depth), order(d, set(in.nearest_m))),
                                    hn::Gt(order(d, depth), order(d, set(in.farthest_m))));
        hn::StoreU(hn::IfThenZeroElse(hn::RebindMask(d, outside), depth), d, z + i);
        valid += static_cast<int>(hn::Lanes(d)) - static_cast<int>(hn::CountTrue(di, outside));
    });
    return valid;
}

void grow(const std::uint8_t *HWY_RESTRICT next, int count, std::uint8_t *HWY_RESTRICT values) {
    for (int i = 0; i < count; ++i) // for the compiler, which makes vector code of it
        values[i] = std::min(values[i], static_cast<std::uint8_t>(next[i] + 1));
}

Slopes compare(const float *HWY_RESTRICT pixels, const float *HWY_RESTRICT next, int count,
               const EdgeRule &of, std::uint8_t *HWY_RESTRICT found) {
    const EdgeRule rule = of; // a copy, which nothing written here can change
    Slopes slopes;
    for_lanes(count, [&](auto d, int i) HWY_ATTR {
        const hn::RebindToSigned<decltype(d)> di;
        const hn::Rebind<std::uint8_t, decltype(d)> d8;
        const auto zero = hn::Zero(d);
        const auto a = hn::LoadU(d, pixels + i), b = hn::LoadU(d, next + i);
        const auto near = hn::Min(a, b), difference = hn::Abs(hn::Sub(a, b));
        const auto noise = sigma(d, rule.noise, near);
        const auto step = hn::Add(hn::Mul(hn::Set(d, rule.edge_relative), near),
                                  hn::Mul(hn::Set(d, 3.0f), noise));
        const auto empty = hn::RebindMask(di, hn::Eq(a, zero));
        const auto hole = hn::AndNot(empty, hn::RebindMask(di, hn::Eq(b, zero)));
        const auto both = hn::Not(hn::Or(empty, hole));
        const auto far = hn::Gt(order(d, difference), order(d, step));
        const auto parted = hn::And(both, far), alike = hn::AndNot(far, both);
        const auto slope =
            hn::Min(hn::Div(hn::Max(hn::Sub(difference, noise), zero), near), hn::Set(d, 1.0f));
        const auto units = hn::ConvertTo(di, hn::Mul(slope, hn::Set(d, 1048576.0f)));
        slopes.sum += hn::GetLane(hn::SumOfLanes(di, hn::IfThenElseZero(alike, units)));
        slopes.pairs += static_cast<int>(hn::CountTrue(di, alike));
        const auto kind = hn::Or(hn::IfThenElseZero(parted, hn::Set(di, 1)),
                                 hn::IfThenElseZero(hole, hn::Set(di, 2)));
        hn::StoreU(hn::DemoteTo(d8, kind), d8, found + i);
    });
    return slopes;
}

} // namespace
} // namespace afterglow::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace afterglow {
namespace {

HWY_EXPORT(smooth);
HWY_EXPORT(load);
HWY_EXPORT(grow);
HWY_EXPORT(compare);

} // namespace

void smooth_row(const SmoothedRow &in, const SensorNoise &noise, float *out) {
    HWY_DYNAMIC_DISPATCH(smooth)(in, noise, out);
}

int load_row(const ReadingRow &in, float *z) {
    return HWY_DYNAMIC_DISPATCH(load)(in, z);
}

void grow_from_row(const std::uint8_t *next, int count, std::uint8_t *values) {
    HWY_DYNAMIC_DISPATCH(grow)(next, count, values);
}

Slopes compare_neighbours(const float *pixels, const float *next, int count, const EdgeRule &rule,
                          Neighbours *found) {
    return HWY_DYNAMIC_DISPATCH(compare)(pixels, next, count, rule,
                                         reinterpret_cast<std::uint8_t *>(found));
}

} // namespace afterglow
#endif
