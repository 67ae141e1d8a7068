// SPDX-License-Identifier: Apache-2.0
// Compiled once for each instruction set; the best of them is chosen when first called.
#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "core/error/map_comparison.cpp"
#include "core/error/map_comparison.hpp"

#include "core/estimate.hpp"

#include <algorithm>
#include <cstdlib>
#include <hwy/cache_control.h>
#include <hwy/foreach_target.h>
#include <hwy/highway.h>

HWY_BEFORE_NAMESPACE();
namespace afterglow::HWY_NAMESPACE {
namespace {

namespace hn = hwy::HWY_NAMESPACE;

void compare_singly(const ComparedPixels &in, int v, int first, float misplaced,
                    ComparedErrors &errors) {
    for (int u = first; u < in.composed.width(); u += 2) {
        const int truth = in.measured(u, v), shown = in.composed(u, v);
        if (truth == 0 || shown == 0)
            continue;
        errors.true_sum += static_cast<float>(std::abs(shown - truth)) / static_cast<float>(truth);
        errors.expected_sum +=
            std::max(expected_error(in.confidence(u, v)) - misplaced, confidence_step);
        ++errors.pixels;
    }
}

ComparedErrors compare(const ComparedPixels &pixels, float misplaced) {
    const ComparedPixels in = pixels;
    ComparedErrors errors;
    int compared_columns = 0;
#if HWY_TARGET != HWY_SCALAR
    const hn::CappedTag<std::int32_t, 8> d;
    const hn::RebindToFloat<decltype(d)> df;
    const hn::Repartition<std::uint16_t, decltype(d)> d16;
    const hn::Rebind<std::uint16_t, decltype(d)> of_confidences;
    const hn::Repartition<std::uint8_t, decltype(of_confidences)> d8;
    // Sums of four lanes everywhere have one order on every machine.
    const hn::CappedTag<float, 4> d_sum;
    constexpr int columns = 2 * static_cast<int>(hn::MaxLanes(d));
    compared_columns = in.composed.width() / columns * columns;
    // The first of each pair of pixels is in the lower half.
    const auto even_columns = [&](const std::uint16_t *from) HWY_ATTR {
        return hn::And(hn::BitCast(d, hn::LoadU(d16, from)), hn::Set(d, 0xffff));
    };
    const auto zero = hn::Zero(d), most = hn::Set(d, measured_confidence);
    const auto step = hn::Set(df, confidence_step), less = hn::Set(df, misplaced);
    auto true_sum = hn::Zero(d_sum), expected_sum = hn::Zero(d_sum);
    const auto add = [&](auto &sum, auto errors_of) HWY_ATTR {
        if constexpr (hn::MaxLanes(df) > hn::MaxLanes(d_sum)) {
            sum = hn::Add(sum, hn::LowerHalf(d_sum, errors_of));
            sum = hn::Add(sum, hn::UpperHalf(d_sum, errors_of));
        } else {
            sum = hn::Add(sum, errors_of);
        }
    };
    auto count = zero;
    for (int v = 0; v < in.composed.height(); v += 2) {
        const std::uint16_t *const measured = in.measured.row(v);
        const std::uint16_t *const composed = in.composed.row(v);
        const std::uint8_t *const confidences = in.confidence.row(v);
        // The same row of the cell after the next one to the right, which is compared soon.
        hwy::Prefetch(measured + 2 * in.composed.width());
        hwy::Prefetch(composed + 2 * in.composed.width());
        hwy::Prefetch(confidences + 2 * in.composed.width());
        for (int u = 0; u < compared_columns; u += columns) {
            const auto truth = even_columns(measured + u), shown = even_columns(composed + u);
            const auto pairs = hn::LoadU(d8, confidences + u);
            const auto confidence = hn::PromoteTo(
                d, hn::And(hn::BitCast(of_confidences, pairs), hn::Set(of_confidences, 0xff)));
            const auto both = hn::Gt(hn::Min(truth, shown), zero);
            const auto there = hn::RebindMask(df, both);
            const auto difference = hn::ConvertTo(df, hn::Abs(hn::Sub(shown, truth)));
            add(true_sum, hn::IfThenElseZero(there, hn::Div(difference, hn::ConvertTo(df, truth))));
            const auto expected =
                hn::Sub(hn::Mul(hn::ConvertTo(df, hn::Sub(most, confidence)), step), less);
            add(expected_sum, hn::IfThenElseZero(there, hn::Max(expected, step)));
            count = hn::Sub(count, hn::VecFromMask(d, both));
        }
    }
    errors.true_sum = hn::GetLane(hn::SumOfLanes(d_sum, true_sum));
    errors.expected_sum = hn::GetLane(hn::SumOfLanes(d_sum, expected_sum));
    errors.pixels = hn::GetLane(hn::SumOfLanes(d, count));
#endif
    for (int v = 0; v < in.composed.height(); v += 2)
        compare_singly(in, v, compared_columns, misplaced, errors);
    return errors;
}

} // namespace
} // namespace afterglow::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace afterglow {
namespace {

HWY_EXPORT(compare);

} // namespace

ComparedErrors compare_errors(const ComparedPixels &pixels, float misplaced) {
    return HWY_DYNAMIC_DISPATCH(compare)(pixels, misplaced);
}

} // namespace afterglow
#endif
