// SPDX-License-Identifier: Apache-2.0
//
// Depths in the units of a map, in vectors of 16 bits. Included once for each instruction set, like
// lanes-inl.hpp.
#if defined(AFTERGLOW_CORE_SURFACE_UNIT_DEPTHS_INL_HPP) == defined(HWY_TARGET_TOGGLE)
#ifdef AFTERGLOW_CORE_SURFACE_UNIT_DEPTHS_INL_HPP
#undef AFTERGLOW_CORE_SURFACE_UNIT_DEPTHS_INL_HPP
#else
#define AFTERGLOW_CORE_SURFACE_UNIT_DEPTHS_INL_HPP
#endif

#include "core/surface/unit_depth.hpp"

#include <hwy/highway.h>

HWY_BEFORE_NAMESPACE();
namespace afterglow::HWY_NAMESPACE {
namespace {

namespace hn = hwy::HWY_NAMESPACE;

#if HWY_TARGET == HWY_SCALAR
// One lane, which is both halves.
inline constexpr int lanes = 1;
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
#else
using Units = hn::CappedTag<std::int16_t, most_units_at_once>;
inline constexpr int lanes = static_cast<int>(hn::MaxLanes(Units()));
using HalfUnits = hn::Half<Units>;
template <class V>
HWY_API auto lower_half(V value) {
    return hn::LowerHalf(value);
}
template <class V>
HWY_API auto upper_half(V value) {
    return hn::UpperHalf(HalfUnits(), value);
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

} // namespace
} // namespace afterglow::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#endif
