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

/// Calls work(tag, i) for whole vectors of floats only, of fewer lanes where `count` is less. The
/// last one may begin before the end of the one before: it must do no harm to do work twice.
template <class D, class Work>
[[maybe_unused]] HWY_API void for_overlapping_lanes(D d, int count, const Work &work) {
    const int lanes = static_cast<int>(hn::Lanes(d));
    if (count < lanes) {
        if constexpr (hn::MaxLanes(D()) > 1)
            for_overlapping_lanes(hn::Half<D>(), count, work);
        return;
    }
    const int last = count - lanes;
    for (int i = -lanes; i < last;) {
        i = std::min(i + lanes, last);
        work(d, i);
    }
}
template <class Work>
[[maybe_unused]] HWY_API void for_overlapping_lanes(int count, const Work &work) {
    for_overlapping_lanes(hn::ScalableTag<float>(), count, work);
}

/// Integers that are in the order of the floats, as long as one of the two that are compared is not
/// negative: their bits. All negative floats are below 0, and NaN is above all or below 0. On
/// 32-bit ARM, whose vectors do not compare floats as IEEE 754 wants it, g++ compares floats one by
/// one.
template <class D, class V>
[[maybe_unused]] HWY_API auto order(D /*tag*/, V value) {
    return hn::BitCast(hn::RebindToSigned<D>(), value);
}

[[maybe_unused]] inline constexpr std::array<float, 64> whole_numbers = [] {
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

} // namespace
} // namespace afterglow::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#endif
