// SPDX-License-Identifier: Apache-2.0
// Compiled once for each instruction set; the best of them is chosen when first called.
#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "core/keyframe/residuals.cpp"
#include "core/keyframe/residuals.hpp"

#include <hwy/foreach_target.h>
#include <hwy/highway.h>

// clang-format off: after Highway, once for each instruction set
#include "core/base/lanes-inl.hpp"
// clang-format on

HWY_BEFORE_NAMESPACE();
namespace afterglow::HWY_NAMESPACE {
namespace {

constexpr float nearest_m = 0.05f;

/// Point X is at A X + b, homogeneous pixels.
void residuals_of(const TemplatePoints &points, int first, ImageView<const float> image,
                  const Eigen::Matrix3f &A, const Eigen::Vector3f &b, const Placement &at,
                  Residuals &out) {
    const hn::CappedTag<float, TemplatePoints::block> d;
    const hn::RebindToSigned<decltype(d)> di;
    const auto set = [&](float value) HWY_ATTR { return hn::Set(d, value); };
    const auto sx = set(at.skew[0]), sy = set(at.skew[1]), sz = set(at.skew[2]);
    // The last pixel has no neighbour to interpolate with.
    const auto last_u = order(d, set(static_cast<float>(image.width() - 1) - 0.01f));
    const auto last_v = order(d, set(static_cast<float>(image.height() - 1) - 0.01f));
    const auto outside = hn::Set(di, -1);
    for (int i = 0; i < TemplatePoints::block; i += static_cast<int>(hn::Lanes(d))) {
        const auto load = [&](const std::vector<float> &column)
                              HWY_ATTR { return hn::LoadU(d, column.data() + first + i); };
        const auto x0 = load(points.x), y0 = load(points.y), z0 = load(points.z);
        const auto row = load(points.row);
        const auto tx = hn::Mul(sx, row), ty = hn::Mul(sy, row), tz = hn::Mul(sz, row);
        const auto x = hn::Sub(hn::Add(x0, hn::Mul(ty, z0)), hn::Mul(tz, y0));
        const auto y = hn::Sub(hn::Add(y0, hn::Mul(tz, x0)), hn::Mul(tx, z0));
        const auto z = hn::Sub(hn::Add(z0, hn::Mul(tx, y0)), hn::Mul(ty, x0));
        const auto along = [&](int k) HWY_ATTR {
            const auto xy = hn::Add(hn::Mul(set(A(k, 0)), x), hn::Mul(set(A(k, 1)), y));
            return hn::Add(hn::Add(xy, hn::Mul(set(A(k, 2)), z)), set(b[k]));
        };
        const auto depth = along(2);
        const auto inverse = hn::Div(set(1.0f), depth);
        const auto u = hn::Mul(along(0), inverse), v = hn::Mul(along(1), inverse);
        const auto in_u = hn::And(hn::Gt(order(d, u), outside), hn::Lt(order(d, u), last_u));
        const auto in_v = hn::And(hn::Gt(order(d, v), outside), hn::Lt(order(d, v), last_v));
        const auto exists = hn::Lt(hn::Iota(di, first + i), hn::Set(di, points.count));
        const auto in_front = hn::Gt(order(d, depth), order(d, set(nearest_m)));
        const auto seen =
            hn::RebindMask(d, hn::And(hn::And(exists, in_front), hn::And(in_u, in_v)));
        const auto at_u = hn::IfThenElseZero(seen, u), at_v = hn::IfThenElseZero(seen, v);
        const auto iu = hn::ConvertTo(di, at_u), iv = hn::ConvertTo(di, at_v);
        const auto fu = hn::Sub(at_u, hn::ConvertTo(d, iu));
        const auto fv = hn::Sub(at_v, hn::ConvertTo(d, iv));
        const auto offset = hn::Add(hn::Mul(iv, hn::Set(di, image.stride())), iu);
        const auto interpolate = [&](const float *from) HWY_ATTR {
            const auto left = hn::GatherIndex(d, from, offset);
            return hn::Add(left, hn::Mul(fu, hn::Sub(hn::GatherIndex(d, from + 1, offset), left)));
        };
        const auto upper = interpolate(image.row(0));
        const auto lower = interpolate(image.row(1));
        const auto grey = hn::Add(upper, hn::Mul(fv, hn::Sub(lower, upper)));
        const auto error =
            hn::Sub(hn::Sub(grey, hn::Mul(set(at.gain), load(points.intensity))), set(at.offset));
        hn::StoreU(at_u, d, out.u.data() + i);
        hn::StoreU(at_v, d, out.v.data() + i);
        hn::StoreU(depth, d, out.depth.data() + i);
        hn::StoreU(hn::IfThenElseZero(seen, error), d, out.error.data() + i);
        hn::StoreU(hn::IfThenElseZero(seen, set(1.0f)), d, out.seen.data() + i);
    }
}

} // namespace
} // namespace afterglow::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace afterglow {
namespace {

HWY_EXPORT(residuals_of);

} // namespace

void find_residuals(const TemplatePoints &points, int first, ImageView<const float> image,
                    const Intrinsics &camera, const Placement &at, Residuals &residuals) {
    const Eigen::Matrix3d K = camera.matrix();
    HWY_DYNAMIC_DISPATCH(residuals_of)
    (points, first, image, (K * at.pose.R).cast<float>(), (K * at.pose.T).cast<float>(), at,
     residuals);
}

} // namespace afterglow
#endif
