// SPDX-License-Identifier: Apache-2.0
//
// Points of a surface in vectors. Included once for each instruction set, like lanes-inl.hpp.
#if defined(AFTERGLOW_CORE_SURFACE_SURFACE_POINT_INL_HPP) == defined(HWY_TARGET_TOGGLE)
#ifdef AFTERGLOW_CORE_SURFACE_SURFACE_POINT_INL_HPP
#undef AFTERGLOW_CORE_SURFACE_SURFACE_POINT_INL_HPP
#else
#define AFTERGLOW_CORE_SURFACE_SURFACE_POINT_INL_HPP
#endif

#include "core/surface/surface_point.hpp"

#include <hwy/highway.h>

HWY_BEFORE_NAMESPACE();
namespace afterglow::HWY_NAMESPACE {
namespace {

namespace hn = hwy::HWY_NAMESPACE;

/// Steepest slope along which a depth is moved, share of the depth per pixel.
inline constexpr float steepest = 0.03f;

/// Edge distances of points, pixels, 0 where there is none.
template <class D, class V>
HWY_API auto edge_of(D /*tag*/, V z) {
    const hn::RebindToSigned<D> di;
    return hn::And(hn::BitCast(di, z), hn::Set(di, edge_distance_bits));
}

} // namespace
} // namespace afterglow::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#endif
