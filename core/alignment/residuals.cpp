// SPDX-License-Identifier: Apache-2.0
// Compiled once for each instruction set; the best of them is chosen when first called.
#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "core/alignment/residuals.cpp"
#include "core/alignment/residuals.hpp"

#include <cassert>
#include <cstring>
#include <hwy/foreach_target.h>
#include <hwy/highway.h>

// clang-format off: after Highway, once for each instruction set
#include "core/base/camera.hpp"
#include "core/base/lanes-inl.hpp"
// clang-format on

HWY_BEFORE_NAMESPACE();
namespace afterglow::HWY_NAMESPACE {
namespace {

using Lanes = hn::CappedTag<float, TemplatePoints::block>;

/// For each lane image[place] and, in the upper half, image[place + 1].
template <class D>
HWY_API hn::Vec<hn::RebindToUnsigned<D>> pairs_at(D /*d*/, const Grey *image,
                                                  const std::int32_t *places) {
    const hn::RebindToUnsigned<D> pairs;
    [[maybe_unused]] const auto pair = [&](int i) HWY_ATTR {
        std::uint32_t two;
        std::memcpy(&two, image + places[i], sizeof two);
        return two;
    };
#if HWY_TARGET == HWY_SCALAR
    return hn::Set(pairs, pair(0));
#else
    if constexpr (hn::MaxLanes(D()) == 4) { // no gather instruction, or a slow one
        const hn::Repartition<std::uint64_t, D> d64;
        const auto two = [&](int i) HWY_ATTR {
            return hn::Set(hn::Half<decltype(d64)>(), std::uint64_t{pair(i + 1)} << 32 | pair(i));
        };
        return hn::BitCast(pairs, hn::Combine(d64, two(2), two(0)));
    } else {
        const auto offsets = hn::ShiftLeft<1>(hn::Load(hn::RebindToSigned<D>(), places)); // bytes
        return hn::GatherOffset(pairs, reinterpret_cast<const std::uint32_t *>(image), offsets);
    }
#endif
}

/// As neighbours_at(), of grey values, in steps.
template <class D>
HWY_API Neighbours<hn::Vec<D>> greys_near(D d, GreyView image, const std::int32_t *places) {
    // Two neighbours of a row are loaded at once: the left one is in the lower half.
    const hn::RebindToUnsigned<D> pairs;
    const auto left = [&](auto two) HWY_ATTR { return hn::And(two, hn::Set(pairs, 0xffff)); };
    const auto value = [&](auto greys) HWY_ATTR {
        return hn::ConvertTo(d, hn::BitCast(hn::RebindToSigned<D>(), greys));
    };
    const auto above = pairs_at(d, image.data(), places);
    const auto below = pairs_at(d, image.data() + image.stride(), places);
    return {value(left(above)), value(hn::ShiftRight<16>(above)), value(left(below)),
            value(hn::ShiftRight<16>(below))};
}

/// Looks up points first .. first + Lanes: visit(u, v, depth, grey), as in PointsSeen. Point X is
/// at A X + b, homogeneous pixels.
template <class Visit>
HWY_INLINE void look_up(const TemplatePoints &points, int first, GreyView image,
                        const Eigen::Matrix3f &A, const Eigen::Vector3f &b, const Placement &at,
                        const Visit &visit) {
    const Lanes d;
    const hn::RebindToSigned<Lanes> di;
    const auto set = [&](float value) HWY_ATTR { return hn::Set(d, value); };
    const auto load = [&](const AlignedVector<float> &column)
                          HWY_ATTR { return hn::LoadU(d, column.data() + first); };
    const auto x0 = load(points.x), y0 = load(points.y), z0 = load(points.z);
    const auto row = load(points.row);
    const auto tx = hn::Mul(set(at.skew[0]), row), ty = hn::Mul(set(at.skew[1]), row);
    const auto tz = hn::Mul(set(at.skew[2]), row);
    const auto x = hn::NegMulAdd(tz, y0, hn::MulAdd(ty, z0, x0));
    const auto y = hn::NegMulAdd(tx, z0, hn::MulAdd(tz, x0, y0));
    const auto z = hn::NegMulAdd(ty, x0, hn::MulAdd(tx, y0, z0));
    const auto along = [&](int k) HWY_ATTR {
        return hn::MulAdd(set(A(k, 0)), x,
                          hn::MulAdd(set(A(k, 1)), y, hn::MulAdd(set(A(k, 2)), z, set(b[k]))));
    };
    const auto depth = along(2);
    const auto inverse = hn::Div(set(1.0f), depth);
    const auto u = hn::Mul(along(0), inverse), v = hn::Mul(along(1), inverse);
    // The last pixel has no neighbour to interpolate with.
    const auto outside = hn::Set(di, -1);
    const auto before = [&](auto place, int size) HWY_ATTR {
        return hn::Lt(order(d, place), order(d, set(static_cast<float>(size - 1) - 0.01f)));
    };
    const auto in_u = hn::And(hn::Gt(order(d, u), outside), before(u, image.width()));
    const auto in_v = hn::And(hn::Gt(order(d, v), outside), before(v, image.height()));
    const auto exists =
        hn::Lt(order(d, ramp(d, first)), order(d, set(static_cast<float>(points.count))));
    const auto in_front = hn::Gt(order(d, depth), order(d, set(float{nearest_seen_m})));
    const auto seen = hn::RebindMask(d, hn::And(hn::And(exists, in_front), hn::And(in_u, in_v)));
    const auto at_u = hn::IfThenElseZero(seen, u), at_v = hn::IfThenElseZero(seen, v);
    const auto iu = truncated(di, at_u), iv = truncated(di, at_v);
    const auto fu = hn::Sub(at_u, hn::ConvertTo(d, iu));
    const auto fv = hn::Sub(at_v, hn::ConvertTo(d, iv));
    const auto offset = hn::Add(hn::Mul(iv, hn::Set(di, image.stride())), iu);
    HWY_ALIGN std::int32_t places[TemplatePoints::block];
    hn::Store(offset, di, places);
    const auto seen_at = greys_near(d, image, places);
    const auto upper = hn::MulAdd(fu, hn::Sub(seen_at.b, seen_at.a), seen_at.a);
    const auto lower = hn::MulAdd(fu, hn::Sub(seen_at.e, seen_at.c), seen_at.c);
    const auto grey = hn::Mul(set(grey_step), hn::MulAdd(fv, hn::Sub(lower, upper), upper));
    visit(at_u, at_v, depth, hn::IfThenElse(seen, hn::Max(grey, hn::Zero(d)), set(-1.0f)));
}

void points_of(const TemplatePoints &points, int first, int end, GreyView image,
               const Eigen::Matrix3f &A, const Eigen::Vector3f &b, const Placement &at,
               PointsSeen &seen) {
    const Lanes d;
    for (int i = 0; i < end - first; i += static_cast<int>(hn::Lanes(d)))
        look_up(points, first + i, image, A, b, at,
                [&](auto u, auto v, auto depth, auto grey) HWY_ATTR {
                    hn::StoreU(u, d, seen.u.data() + i);
                    hn::StoreU(v, d, seen.v.data() + i);
                    hn::StoreU(depth, d, seen.depth.data() + i);
                    hn::StoreU(grey, d, seen.grey.data() + i);
                });
}

void greys_of(const TemplatePoints &points, int first, int end, GreyView image,
              const Eigen::Matrix3f &A, const Eigen::Vector3f &b, const Placement &at,
              std::span<float> greys) {
    const Lanes d;
    for (int i = first; i < end; i += static_cast<int>(hn::Lanes(d)))
        look_up(points, i, image, A, b, at, [&](auto, auto, auto, auto grey) HWY_ATTR {
            hn::StoreU(grey, d, greys.data() + i);
        });
}

void residuals_of(const TemplatePoints &points, int first, int end, const float *HWY_RESTRICT greys,
                  const Placement &at, float robust_width, Residuals &out) {
    const Lanes d;
    const hn::RebindToSigned<Lanes> di;
    const auto set = [&](float value) HWY_ATTR { return hn::Set(d, value); };
    const auto width2 = set(robust_width * robust_width);
    const auto gain = set(at.gain), offset = set(at.offset);
    const auto most_bins = set(static_cast<float>(Residuals::bins - 1));
    const float *grey_at = greys;
    const float *per_s_at = points.per_s.data() + first;
    const float *intensity_at = points.intensity.data() + first;
    for (int i = 0; i < end - first; i += static_cast<int>(hn::Lanes(d))) {
        const auto grey = load_next(d, grey_at), per_s = load_next(d, per_s_at);
        const auto promised = hn::MulAdd(gain, load_next(d, intensity_at), offset);
        const auto white_seen = hn::Gt(order(d, grey), order(d, set(nearly_white)));
        const auto white_promised = hn::Gt(order(d, promised), order(d, set(white)));
        const auto is_seen = hn::AndNot(hn::And(white_seen, white_promised),
                                        hn::Gt(order(d, grey), hn::Set(di, -1)));
        const auto seen = hn::RebindMask(d, is_seen);
        const auto error = hn::IfThenElseZero(seen, hn::Sub(grey, promised));
        const auto r = hn::Mul(hn::Abs(error), per_s);
        const auto robust = hn::Div(width2, hn::MulAdd(r, r, width2));
        const auto root = hn::Mul(robust, per_s);
        const auto weight = hn::Mul(root, root);
        const auto bin =
            truncated(di, hn::Min(hn::Mul(r, set(1.0f / Residuals::bin_width)), most_bins));
        hn::StoreU(error, d, out.error.data() + i);
        hn::StoreU(hn::IfThenElseZero(seen, weight), d, out.weight.data() + i);
        hn::StoreU(hn::IfThenElse(is_seen, bin, hn::Set(di, Residuals::bins)), di,
                   out.bin.data() + i);
    }
}

} // namespace
} // namespace afterglow::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace afterglow {
namespace {

HWY_EXPORT(points_of);
HWY_EXPORT(greys_of);
HWY_EXPORT(residuals_of);

/// To homogeneous pixels.
struct Projection {
    Projection(const Intrinsics &camera, const Pose &pose)
        : A((camera.matrix() * pose.R).cast<float>()), b((camera.matrix() * pose.T).cast<float>()) {
    }
    Eigen::Matrix3f A;
    Eigen::Vector3f b;
};

} // namespace

void find_points(const TemplatePoints &points, int first, int end, GreyView image,
                 const Intrinsics &camera, const Placement &at, PointsSeen &seen) {
    assert(end - first <= Residuals::most_points);
    const Projection to(camera, at.pose);
    HWY_DYNAMIC_DISPATCH(points_of)(points, first, end, image, to.A, to.b, at, seen);
}

void find_greys(const TemplatePoints &points, int first, int end, GreyView image,
                const Intrinsics &camera, const Placement &at, std::span<float> grey) {
    const Projection to(camera, at.pose);
    HWY_DYNAMIC_DISPATCH(greys_of)(points, first, end, image, to.A, to.b, at, grey);
}

void find_residuals(const TemplatePoints &points, int first, int end, const float *grey,
                    const Placement &at, float robust_width, Residuals &residuals) {
    assert(end - first <= Residuals::most_points);
    HWY_DYNAMIC_DISPATCH(residuals_of)(points, first, end, grey, at, robust_width, residuals);
}

} // namespace afterglow
#endif
