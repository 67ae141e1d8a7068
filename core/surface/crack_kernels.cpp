// SPDX-License-Identifier: Apache-2.0
// Compiled once for each instruction set; the best of them is chosen when first called.
#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "core/surface/crack_kernels.cpp"
#include "core/surface/crack_kernels.hpp"

#include "core/surface/surface_point.hpp"

#include <hwy/foreach_target.h>
#include <hwy/highway.h>

// clang-format off: after Highway, once for each instruction set
#include "core/base/lanes-inl.hpp"
#include "core/surface/sensor_noise-inl.hpp"
// clang-format on

HWY_BEFORE_NAMESPACE();
namespace afterglow::HWY_NAMESPACE {
namespace {

void find_points_inside(const UnitDepth *HWY_RESTRICT z,
                        const std::uint8_t *HWY_RESTRICT edge_distance, int count,
                        std::uint8_t *HWY_RESTRICT inside) {
    for (int u = 0; u < count; ++u) // for the compiler, which makes vector code of it
        inside[u] = static_cast<std::uint8_t>((z[u] != 0) & (edge_distance[u] > 1));
}

/// 1 where a pixel that is not inside a surface lies between two that are, else 0.
template <class D>
HWY_API hn::Vec<D> cracks_at(D d8, const std::uint8_t *inside, std::ptrdiff_t stride) {
    // Between two in a direction, one of them the next.
    const auto between = [&](std::ptrdiff_t step) HWY_ATTR {
        const auto before2 = hn::LoadU(d8, inside - 2 * step);
        const auto before = hn::LoadU(d8, inside - step);
        const auto after = hn::LoadU(d8, inside + step);
        const auto after2 = hn::LoadU(d8, inside + 2 * step);
        return hn::Or(hn::And(before, hn::Or(after, after2)), hn::And(before2, after));
    };
    const auto straight = hn::Or(between(1), between(stride));
    const auto diagonal = hn::Or(between(stride + 1), between(stride - 1));
    return hn::AndNot(hn::LoadU(d8, inside), hn::Or(straight, diagonal));
}

/// Fills the pixels of a vector that are marked in `cracks`.
template <class D>
HWY_INLINE void fill(D d, const std::uint8_t *inside, std::ptrdiff_t stride, const CrackRule &rule,
                     const std::uint8_t *cracks, float *points) {
    const hn::RebindToSigned<D> di;
    const hn::Rebind<std::uint8_t, D> d8;
    const auto zero = hn::Zero(di);
    const auto is_set = [&](const std::uint8_t *at)
                            HWY_ATTR { return hn::Gt(hn::PromoteTo(di, hn::LoadU(d8, at)), zero); };
    const auto relative = hn::Set(d, rule.surface.edge_relative), three = hn::Set(d, 3);
    auto sum = hn::Zero(d), pairs = hn::Zero(d);
    for (const std::ptrdiff_t step : {std::ptrdiff_t{1}, stride, stride + 1, 1 - stride}) {
        const auto next_before = is_set(inside - step), next_after = is_set(inside + step);
        auto between = hn::And(next_before, next_after);
        auto before = hn::LoadU(d, points - step), after = hn::LoadU(d, points + step);
        auto share = hn::Set(d, 1.0f / 2);
        if (rule.widest > 1) {
            const auto wider_before = hn::AndNot(next_before, is_set(inside - 2 * step));
            const auto wider_after = hn::AndNot(next_after, is_set(inside + 2 * step));
            before = hn::IfThenElse(hn::RebindMask(d, next_before), before,
                                    hn::LoadU(d, points - 2 * step));
            after = hn::IfThenElse(hn::RebindMask(d, next_after), after,
                                   hn::LoadU(d, points + 2 * step));
            const auto third = hn::And(next_before, wider_after);
            const auto two_thirds = hn::And(wider_before, next_after);
            share = hn::IfThenElse(hn::RebindMask(d, third), hn::Set(d, 1.0f / 3), share);
            share = hn::IfThenElse(hn::RebindMask(d, two_thirds), hn::Set(d, 2.0f / 3), share);
            between = hn::Or(between, hn::Or(third, two_thirds));
        }
        const auto near = hn::Min(before, after), difference = hn::Sub(after, before);
        const auto parting =
            hn::Add(hn::Mul(relative, near), hn::Mul(three, sigma(d, rule.surface.noise, near)));
        const auto parted = hn::Gt(order(d, hn::Abs(difference)), order(d, parting));
        const auto ok = hn::RebindMask(d, hn::AndNot(parted, between));
        sum = hn::Add(sum, hn::IfThenElseZero(ok, hn::Add(before, hn::Mul(share, difference))));
        pairs = hn::Add(pairs, hn::IfThenElseZero(ok, hn::Set(d, 1)));
    }
    const auto mean = hn::BitCast(di, hn::Div(sum, hn::Max(pairs, hn::Set(d, 1))));
    const auto with_edge =
        hn::Or(hn::AndNot(hn::Set(di, edge_distance_bits), mean), hn::Set(di, beside_edge));
    const auto filled = hn::And(is_set(cracks), hn::Gt(hn::BitCast(di, pairs), zero));
    hn::StoreU(
        hn::IfThenElse(hn::RebindMask(d, filled), hn::BitCast(d, with_edge), hn::LoadU(d, points)),
        d, points);
}

void fill_cracks(const std::uint8_t *inside, std::ptrdiff_t stride, int count,
                 const CrackRule &rule, float *points) {
    const hn::CappedTag<std::uint8_t, 32> d;
    for_overlapping_lanes(d, count, [&](auto d8, int i) HWY_ATTR {
        // Most points are inside a surface.
        if (hn::AllTrue(d8, hn::Ne(hn::LoadU(d8, inside + i), hn::Zero(d8))))
            return;
        const auto cracks = cracks_at(d8, inside + i, stride);
        if (hn::AllTrue(d8, hn::Eq(cracks, hn::Zero(d8))))
            return;
        constexpr std::size_t at_once = hn::MaxLanes(d8);
        const hn::CappedTag<float, at_once> of_points;
        HWY_ALIGN std::uint8_t marked[at_once];
        hn::Store(cracks, d8, marked);
        for (std::size_t k = 0; k < at_once; k += hn::MaxLanes(of_points)) {
            const std::ptrdiff_t at = i + static_cast<std::ptrdiff_t>(k);
            const hn::Rebind<std::uint8_t, decltype(of_points)> some;
            if (!hn::AllTrue(some, hn::Eq(hn::Load(some, marked + k), hn::Zero(some))))
                fill(of_points, inside + at, stride, rule, marked + k, points + at);
        }
    });
}

} // namespace
} // namespace afterglow::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace afterglow {
namespace {

HWY_EXPORT(find_points_inside);
HWY_EXPORT(fill_cracks);

} // namespace

void find_inside(const UnitDepth *z, const std::uint8_t *edge_distance, int count,
                 std::uint8_t *inside) {
    HWY_DYNAMIC_DISPATCH(find_points_inside)(z, edge_distance, count, inside);
}

void fill_cracks_of_row(const std::uint8_t *inside, std::ptrdiff_t stride, int count,
                        const CrackRule &rule, float *points) {
    HWY_DYNAMIC_DISPATCH(fill_cracks)(inside, stride, count, rule, points);
}

} // namespace afterglow
#endif
