// SPDX-License-Identifier: Apache-2.0
//
// What kernels share. Included once for each instruction set, after hwy/highway.h, by files that
// are compiled so (Highway's foreach_target.h).
#if defined(AFTERGLOW_CORE_BASE_LANES_INL_HPP) == defined(HWY_TARGET_TOGGLE)
#ifdef AFTERGLOW_CORE_BASE_LANES_INL_HPP
#undef AFTERGLOW_CORE_BASE_LANES_INL_HPP
#else
#define AFTERGLOW_CORE_BASE_LANES_INL_HPP
#endif

#include "core/base/grey.hpp"

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <hwy/highway.h>

HWY_BEFORE_NAMESPACE();
namespace afterglow::HWY_NAMESPACE {
namespace {

namespace hn = hwy::HWY_NAMESPACE;

/// Calls work(tag, i) for i in steps of whole vectors of floats, and one by one for the rest.
template <class Work>
[[maybe_unused]] HWY_API void for_lanes(int count, const Work &work) {
    const hn::ScalableTag<float> whole;
    const hn::CappedTag<float, 1> single;
    const int lanes = static_cast<int>(hn::Lanes(whole));
    int i = 0;
    for (; i + lanes <= count; i += lanes)
        work(whole, i);
    for (; i < count; ++i)
        work(single, i);
}

/// Calls work(first) for the first value of each vector of `lanes` values. All vectors are whole
/// and are among `count` values, at least `lanes`, so that the last one may begin before the end of
/// the one before: it must do no harm to do work twice.
template <class Work>
[[maybe_unused]] HWY_API void for_overlapping_vectors(int lanes, int count, const Work &work) {
    const int last = count - lanes;
    for (int i = -lanes; i < last;) {
        i = std::min(i + lanes, last);
        work(i);
    }
}

/// Calls work(tag, i) likewise, for vectors of fewer lanes where `count` is less.
template <class D, class Work>
[[maybe_unused]] HWY_API void for_overlapping_lanes(D d, int count, const Work &work) {
    const int lanes = static_cast<int>(hn::Lanes(d));
    if (count < lanes) {
        if constexpr (hn::MaxLanes(D()) > 1)
            for_overlapping_lanes(hn::Half<D>(), count, work);
        return;
    }
    for_overlapping_vectors(lanes, count, [&](int i) HWY_ATTR { work(d, i); });
}
template <class Work>
[[maybe_unused]] HWY_API void for_overlapping_lanes(int count, const Work &work) {
    for_overlapping_lanes(hn::ScalableTag<float>(), count, work);
}

/// The values at a pointer, which is moved to those behind: on small targets a load does that by
/// the way.
template <class D>
[[maybe_unused]] HWY_API hn::Vec<D> load_next(D d, const hn::TFromD<D> *&from) {
    const auto values = hn::LoadU(d, from);
    from += hn::MaxLanes(d);
    return values;
}

/// Integers that are in the order of the floats, as long as one of the two that are compared is not
/// negative: their bits. All negative floats are below 0, and NaN is above all or below 0. On
/// 32-bit ARM, whose vectors do not compare floats as IEEE 754 wants it, g++ compares floats one by
/// one.
template <class D, class V>
[[maybe_unused]] HWY_API auto order(D /*tag*/, V value) {
    return hn::BitCast(hn::RebindToSigned<D>(), value);
}

[[maybe_unused]] alignas(64) inline constexpr std::array<float, 64> whole_numbers = [] {
    std::array<float, 64> numbers{};
    for (std::size_t i = 0; i < numbers.size(); ++i)
        numbers[i] = static_cast<float>(i);
    return numbers;
}();

/// first, first + 1, ...; as a table, since g++ makes it number by number.
template <class D>
[[maybe_unused]] HWY_API auto ramp(D d, int first) {
    return hn::Add(hn::LoadU(d, whole_numbers.data()), hn::Set(d, static_cast<float>(first)));
}

/// Floats rounded towards zero, as 32-bit integers. A float that no such integer is near, and NaN,
/// give a number that depends on the target, so callers limit the floats before or leave such lanes
/// out. hn::ConvertTo() gives the nearest integer, which takes four instructions more on x86.
template <class DI>
[[maybe_unused]] HWY_API hn::Vec<DI> truncated(DI di, hn::Vec<hn::RebindToFloat<DI>> values) {
#if HWY_ARCH_X86 && HWY_TARGET != HWY_SCALAR && HWY_TARGET != HWY_EMU128
    (void)di;
    if constexpr (sizeof values.raw == sizeof(__m128))
        return hn::Vec<DI>{_mm_cvttps_epi32(values.raw)};
#if HWY_TARGET <= HWY_AVX2
    else if constexpr (sizeof values.raw == sizeof(__m256))
        return hn::Vec<DI>{_mm256_cvttps_epi32(values.raw)};
#endif
#if HWY_TARGET <= HWY_AVX3
    else
        return hn::Vec<DI>{_mm512_cvttps_epi32(values.raw)};
#endif
#else
    return hn::ConvertTo(di, values);
#endif
}

/// from[index] of each lane.
template <class D>
[[maybe_unused]] HWY_API hn::Vec<D> gather(D d, const float *from,
                                           hn::Vec<hn::RebindToSigned<D>> index) {
#if HWY_ARCH_ARM_V7
    // Highway stores the indices and loads them again one by one. It takes fewer instructions to
    // move two lanes at a time between a vector and two core registers.
    if constexpr (hn::MaxLanes(D()) == 4) {
        const hn::Repartition<std::uint64_t, D> pairs;
        const auto two = [&](std::uint64_t at) {
            std::uint32_t first, second;
            std::memcpy(&first, from + static_cast<std::int32_t>(at), sizeof first);
            std::memcpy(&second, from + static_cast<std::int32_t>(at >> 32), sizeof second);
            return hn::Set(hn::Half<decltype(pairs)>(), std::uint64_t{second} << 32 | first);
        };
        const auto places = hn::BitCast(pairs, index);
        return hn::BitCast(d, hn::Combine(pairs, two(hn::ExtractLane(places, 1)),
                                          two(hn::ExtractLane(places, 0))));
    }
#endif
    return hn::GatherIndex(d, from, index);
}

/// Grey values, in steps.
template <class D>
[[maybe_unused]] HWY_API hn::Vec<hn::RebindToSigned<D>> grey_steps_at(D /*tag*/, const Grey *from) {
    return hn::PromoteTo(hn::RebindToSigned<D>(), hn::LoadU(hn::Rebind<Grey, D>(), from));
}
/// Half the differences of grey values.
template <class D>
[[maybe_unused]] HWY_API hn::Vec<D> half_difference(D d, const Grey *these, const Grey *less) {
    const auto difference = hn::Sub(grey_steps_at(d, these), grey_steps_at(d, less));
    return hn::Mul(hn::Set(d, 0.5f * grey_step), hn::ConvertTo(d, difference));
}

/// Four neighbours in an image: at the left and right, then below.
template <class V>
struct Neighbours {
    V a, b, c, e;
};
/// For each lane the neighbours of which the first is from[place]; rows are `stride` values apart.
template <class D>
[[maybe_unused]] HWY_API Neighbours<hn::Vec<D>>
neighbours_at(D d, const float *from, std::ptrdiff_t stride, const std::int32_t *places) {
    const float *const upper = from, *const lower = from + stride;
#if HWY_TARGET == HWY_SCALAR
    return {hn::Set(d, upper[*places]), hn::Set(d, upper[*places + 1]), hn::Set(d, lower[*places]),
            hn::Set(d, lower[*places + 1])};
#else
    // Two neighbours of a row are loaded at once.
    const auto unzipped = [&](const auto &above, const auto &below) HWY_ATTR {
        return Neighbours<hn::Vec<D>>{
            hn::ConcatEven(d, above[1], above[0]), hn::ConcatOdd(d, above[1], above[0]),
            hn::ConcatEven(d, below[1], below[0]), hn::ConcatOdd(d, below[1], below[0])};
    };
    if constexpr (hn::MaxLanes(D()) == 4) { // no gather instruction, or a slow one
        const hn::Half<D> pair;
        const auto two = [&](const float *row, int i) HWY_ATTR {
            return hn::Combine(d, hn::LoadU(pair, row + places[i + 1]),
                               hn::LoadU(pair, row + places[i]));
        };
        const hn::Vec<D> above[] = {two(upper, 0), two(upper, 2)};
        const hn::Vec<D> below[] = {two(lower, 0), two(lower, 2)};
        return unzipped(above, below);
    } else {
        const hn::RebindToSigned<D> di;
        const hn::Half<decltype(di)> half;
        const hn::Repartition<std::uint64_t, D> pairs;
        const hn::Repartition<std::int64_t, D> offsets;
        const auto at = hn::ShiftLeft<2>(hn::Load(di, places)); // bytes
        const auto first = hn::PromoteTo(offsets, hn::LowerHalf(half, at));
        const auto last = hn::PromoteTo(offsets, hn::UpperHalf(half, at));
        const auto two = [&](const float *row, auto offset) HWY_ATTR {
            const auto *const from = reinterpret_cast<const std::uint64_t *>(row);
            return hn::BitCast(d, hn::GatherOffset(pairs, from, offset));
        };
        const hn::Vec<D> above[] = {two(upper, first), two(upper, last)};
        const hn::Vec<D> below[] = {two(lower, first), two(lower, last)};
        return unzipped(above, below);
    }
#endif
}

} // namespace
} // namespace afterglow::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#endif
