// SPDX-License-Identifier: Apache-2.0
//
// SensorNoise for kernels. Included once for each instruction set, as core/base/lanes-inl.hpp is.
#if defined(AFTERGLOW_CORE_SURFACE_SENSOR_NOISE_INL_HPP) == defined(HWY_TARGET_TOGGLE)
#ifdef AFTERGLOW_CORE_SURFACE_SENSOR_NOISE_INL_HPP
#undef AFTERGLOW_CORE_SURFACE_SENSOR_NOISE_INL_HPP
#else
#define AFTERGLOW_CORE_SURFACE_SENSOR_NOISE_INL_HPP
#endif

#include "core/surface/sensor_noise.hpp"

#include <hwy/highway.h>

HWY_BEFORE_NAMESPACE();
namespace afterglow::HWY_NAMESPACE {
namespace {

namespace hn = hwy::HWY_NAMESPACE;

/// SensorNoise::sigma() of the depths z.
template <class D, class V>
[[maybe_unused]] HWY_API V sigma(D d, const SensorNoise &noise, V z) {
    const auto curve =
        hn::Add(hn::Set(d, noise.linear), hn::Mul(z, hn::Set(d, noise.quadratic_per_m)));
    return hn::Max(hn::Add(hn::Set(d, noise.floor_m), hn::Mul(z, curve)),
                   hn::Mul(hn::Set(d, noise.least_relative), z));
}

} // namespace
} // namespace afterglow::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#endif
