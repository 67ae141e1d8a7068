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

/// Calls work(i) for whole vectors of `lanes` values, of `count` values in all, at least one
/// vector. The last vector may begin before the end of the one before: it must do no harm to do
/// work twice.
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
#if HWY_TARGET != HWY_SCALAR // which has no pairs
    // Instruction sets with 4 lanes have no gather instruction, or a slow one: they load pairs.
    if constexpr (hn::MaxLanes(D()) == 4) {
        const hn::Half<D> pair;
        const auto two = [&](const float *row, int i) HWY_ATTR {
            return hn::Combine(d, hn::LoadU(pair, row + places[i + 1]),
                               hn::LoadU(pair, row + places[i]));
        };
        const auto above = two(upper, 0), above2 = two(upper, 2);
        const auto below = two(lower, 0), below2 = two(lower, 2);
        return {hn::ConcatEven(d, above2, above), hn::ConcatOdd(d, above2, above),
                hn::ConcatEven(d, below2, below), hn::ConcatOdd(d, below2, below)};
    }
#endif
    const auto at = hn::Load(hn::RebindToSigned<D>(), places);
    return {hn::GatherIndex(d, upper, at), hn::GatherIndex(d, upper + 1, at),
            hn::GatherIndex(d, lower, at), hn::GatherIndex(d, lower + 1, at)};
}

} // namespace
} // namespace afterglow::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#endif
