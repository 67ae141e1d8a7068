// SPDX-License-Identifier: Apache-2.0
//
// Points of a surface in vectors. Included once for each instruction set, like lanes-inl.hpp.
#if defined(AFTERGLOW_CORE_KEYFRAME_SURFACE_POINT_INL_HPP) == defined(HWY_TARGET_TOGGLE)
#ifdef AFTERGLOW_CORE_KEYFRAME_SURFACE_POINT_INL_HPP
#undef AFTERGLOW_CORE_KEYFRAME_SURFACE_POINT_INL_HPP
#else
#define AFTERGLOW_CORE_KEYFRAME_SURFACE_POINT_INL_HPP
#endif

#include "core/keyframe/surface_point.hpp"

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

/// The points beside some points, metres, 0 = none.
template <class V>
struct Around {
    V left, right, above, below;
};

/// How much the depth, metres, changes from points with that edge distance and depth to places that
/// are `along` columns and `down` rows from them: by the slope between the points around, at most
/// `steepest`. 0 where one of these is missing or the point is beside an edge: they may be of
/// another surface.
template <class D, class VI, class V>
HWY_API V rise(D d, VI edge, const Around<V> &around, V depth, V along, V down) {
    const hn::RebindToSigned<D> di;
    const hn::RebindToUnsigned<D> du;
    const auto bits = [&](V value) HWY_ATTR { return hn::BitCast(du, value); };
    const auto least = hn::Min(hn::Min(bits(around.left), bits(around.right)),
                               hn::Min(bits(around.above), bits(around.below)));
    const auto inside = hn::And(hn::Gt(edge, hn::Set(di, beside_edge)),
                                hn::RebindMask(di, hn::Ne(least, hn::Zero(du))));
    const auto most = hn::Mul(hn::Set(d, steepest), depth);
    const auto least_step = hn::Mul(hn::Set(d, -steepest), depth); // Neg() is slow on ARMv7
    const auto slope = [&](V from, V to) HWY_ATTR {
        const auto step = hn::Mul(hn::Set(d, 0.5f), hn::Sub(to, from));
        return hn::Min(hn::Max(step, least_step), most);
    };
    const auto found = hn::Add(hn::Mul(slope(around.left, around.right), along),
                               hn::Mul(slope(around.above, around.below), down));
    return hn::IfThenElseZero(hn::RebindMask(d, inside), found);
}

} // namespace
} // namespace afterglow::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#endif
