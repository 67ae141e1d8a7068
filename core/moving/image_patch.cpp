// SPDX-License-Identifier: Apache-2.0
// Compiled once for each instruction set; the best of them is chosen when first called.
#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "core/moving/image_patch.cpp"
#include "core/moving/image_patch.hpp"

#include <algorithm>
#include <hwy/foreach_target.h>
#include <hwy/highway.h>

// clang-format off: after Highway, once for each instruction set
#include "core/base/lanes-inl.hpp"
// clang-format on

HWY_BEFORE_NAMESPACE();
namespace afterglow::HWY_NAMESPACE {
namespace {

constexpr int side = ImagePatch::side;
constexpr auto count = static_cast<float>(ImagePatch::pixels);
/// Four lanes everywhere: sums have one order on every machine.
using D = hn::CappedTag<float, 4>;
constexpr int lanes = static_cast<int>(hn::MaxLanes(D()));

HWY_API hn::Vec<D> greys_at(const Grey *from) {
    return hn::Mul(hn::Set(D(), grey_step), hn::ConvertTo(D(), grey_steps_at(D(), from)));
}

ImagePatch describe(GreyView image, int u, int v) {
    const D d;
    ImagePatch patch;
    auto sum_u = hn::Zero(d), sum_v = sum_u, uu = sum_u, uv = sum_u, vv = sum_u;
    float *grey = patch.grey.data(), *gradient_u = patch.gradient_u.data(),
          *gradient_v = patch.gradient_v.data();
    for (int j = 0; j < side; ++j)
        for (int i = 0; i < side; i += lanes) {
            const Grey *const at = image.row(v + j) + u + i;
            const auto by_u = half_difference(d, at + 1, at - 1);
            const auto by_v = half_difference(d, at + image.stride(), at - image.stride());
            sum_u = hn::Add(sum_u, by_u);
            sum_v = hn::Add(sum_v, by_v);
            uu = hn::MulAdd(by_u, by_u, uu);
            uv = hn::MulAdd(by_u, by_v, uv);
            vv = hn::MulAdd(by_v, by_v, vv);
            const int k = j * side + i;
            hn::StoreU(greys_at(at), d, grey + k);
            hn::StoreU(by_u, d, gradient_u + k);
            hn::StoreU(by_v, d, gradient_v + k);
        }
    const auto total = [&](auto sum) HWY_ATTR { return hn::GetLane(hn::SumOfLanes(d, sum)); };
    const float mean_u = total(sum_u) / count, mean_v = total(sum_v) / count;
    for (int k = 0; k < side * side; k += lanes) {
        hn::StoreU(hn::Sub(hn::LoadU(d, gradient_u + k), hn::Set(d, mean_u)), d, gradient_u + k);
        hn::StoreU(hn::Sub(hn::LoadU(d, gradient_v + k), hn::Set(d, mean_v)), d, gradient_v + k);
    }
    patch.uu = total(uu) - count * mean_u * mean_u;
    patch.uv = total(uv) - count * mean_u * mean_v;
    patch.vv = total(vv) - count * mean_v * mean_v;
    return patch;
}

/// What is expected of a square that an earlier image shows at `place`, between its pixels.
class ExpectedSquare {
public:
    ExpectedSquare(GreyView image, const Eigen::Vector2f &place, const Brightness &brightness)
        : image_(image), u_(static_cast<int>(place.x())), v_(static_cast<int>(place.y())),
          offset_(hn::Set(D(), brightness.offset)),
          from_white_(hn::Set(D(), brightness.gain * nearly_white)) {
        const D d;
        const float per_step = grey_step * brightness.gain;
        const float right = place.x() - static_cast<float>(u_);
        const float down = place.y() - static_cast<float>(v_);
        a_ = hn::Set(d, per_step * (1 - right) * (1 - down));
        b_ = hn::Set(d, per_step * right * (1 - down));
        c_ = hn::Set(d, per_step * (1 - right) * down);
        e_ = hn::Set(d, per_step * right * down);
    }
    /// How much brighter than what is there `now` the vector is expected that begins in row j and
    /// column i. It is not expected brighter than white, and what was white may have become any
    /// brighter value.
    HWY_INLINE hn::Vec<D> excess(hn::Vec<D> now, int i, int j) const {
        const D d;
        const Grey *const upper = image_.row(v_ + j) + u_ + i;
        const Grey *const lower = upper + image_.stride();
        const auto above = hn::MulAdd(b_, in_steps(upper + 1), hn::Mul(a_, in_steps(upper)));
        const auto below = hn::MulAdd(e_, in_steps(lower + 1), hn::Mul(c_, in_steps(lower)));
        const auto then = hn::Add(above, below);
        const auto more = hn::Sub(hn::Min(hn::Add(then, offset_), hn::Set(d, white)), now);
        const auto was_white = hn::RebindMask(d, hn::Gt(order(d, then), order(d, from_white_)));
        return hn::IfThenElse(was_white, hn::Max(more, hn::Zero(d)), more);
    }

private:
    static HWY_INLINE hn::Vec<D> in_steps(const Grey *from) {
        return hn::ConvertTo(D(), grey_steps_at(D(), from));
    }

    GreyView image_;
    int u_, v_;
    hn::Vec<D> a_, b_, c_, e_;
    hn::Vec<D> offset_, from_white_;
};

PatchFit fit(const ImagePatch &patch, GreyView then, const Eigen::Vector2f &place,
             const Brightness &brightness) {
    const D d;
    const ExpectedSquare expected(then, place, brightness);
    auto sum = hn::Zero(d), squares = sum, by_u = sum, by_v = sum;
    for (int j = 0; j < side; ++j)
        for (int i = 0; i < side; i += lanes) {
            const int k = j * side + i;
            const auto error = expected.excess(hn::LoadU(d, patch.grey.data() + k), i, j);
            sum = hn::Add(sum, error);
            squares = hn::MulAdd(error, error, squares);
            by_u = hn::MulAdd(error, hn::LoadU(d, patch.gradient_u.data() + k), by_u);
            by_v = hn::MulAdd(error, hn::LoadU(d, patch.gradient_v.data() + k), by_v);
        }
    const auto total = [&](auto lane_sums)
                           HWY_ATTR { return hn::GetLane(hn::SumOfLanes(d, lane_sums)); };
    const float mean = total(sum) / count, b_u = total(by_u), b_v = total(by_v);
    const float determinant = patch.uu * patch.vv - patch.uv * patch.uv;
    return {std::max(total(squares) / count - mean * mean, 0.0f),
            Eigen::Vector2f(patch.uv * b_v - patch.vv * b_u, patch.uv * b_u - patch.uu * b_v) /
                determinant};
}

float excess(GreyView image, int u, int v, GreyView then, const Eigen::Vector2f &place,
             const Brightness &brightness) {
    const ExpectedSquare expected(then, place, brightness);
    auto sum = hn::Zero(D());
    for (int j = 0; j < side; ++j)
        for (int i = 0; i < side; i += lanes)
            sum = hn::Add(sum, expected.excess(greys_at(image.row(v + j) + u + i), i, j));
    return hn::GetLane(hn::SumOfLanes(D(), sum)) / count;
}

void claim(GreyView image, int u, int v, GreyView then, const Eigen::Vector2f &place,
           const Brightness &brightness, std::int32_t owner, ImageView<float> least,
           ImageView<std::int32_t> owners) {
    const D d;
    const hn::RebindToSigned<D> di;
    const ExpectedSquare expected(then, place, brightness);
    // With the outermost ones repeated around.
    constexpr int around = side + 2;
    HWY_ALIGN float difference[around][around + 2];
    for (int j = 0; j < side; ++j) {
        float *const row = difference[j + 1];
        for (int i = 0; i < side; i += lanes) {
            const auto now = greys_at(image.row(v + j) + u + i);
            hn::StoreU(hn::Abs(expected.excess(now, i, j)), d, row + 1 + i);
        }
        row[0] = row[1];
        row[side + 1] = row[side];
    }
    std::copy_n(difference[1], around, difference[0]);
    std::copy_n(difference[side], around, difference[side + 1]);
    const auto of_three = [&](const float *row) HWY_ATTR {
        return hn::Add(hn::Add(hn::LoadU(d, row), hn::LoadU(d, row + 1)), hn::LoadU(d, row + 2));
    };
    const auto ninth = hn::Set(d, 1.0f / 9);
    for (int i = 0; i < side; i += lanes) {
        auto above = of_three(difference[0] + i), here = of_three(difference[1] + i);
        for (int j = 0; j < side; ++j) {
            const auto below = of_three(difference[j + 2] + i);
            const auto mean = hn::Mul(ninth, hn::Add(hn::Add(above, here), below));
            float *const least_at = least.row(v + j) + u + i;
            std::int32_t *const owners_at = owners.row(v + j) + u + i;
            const auto before = hn::LoadU(d, least_at);
            const auto less = hn::Lt(order(d, mean), order(d, before));
            hn::StoreU(hn::Min(mean, before), d, least_at);
            hn::StoreU(hn::IfThenElse(less, hn::Set(di, owner), hn::LoadU(di, owners_at)), di,
                       owners_at);
            above = here;
            here = below;
        }
    }
}

} // namespace
} // namespace afterglow::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace afterglow {
namespace {

HWY_EXPORT(describe);
HWY_EXPORT(fit);
HWY_EXPORT(excess);
HWY_EXPORT(claim);

} // namespace

ImagePatch patch_at(GreyView image, int u, int v) {
    return HWY_DYNAMIC_DISPATCH(describe)(image, u, v);
}

bool shows_patch(GreyView image, const Eigen::Vector2f &place) {
    const auto beyond = [](int size) { return static_cast<float>(size - ImagePatch::side); };
    return place.x() >= 0 && place.y() >= 0 && place.x() < beyond(image.width()) &&
           place.y() < beyond(image.height());
}

PatchFit fit_patch(const ImagePatch &patch, GreyView then, const Eigen::Vector2f &place,
                   const Brightness &brightness) {
    return HWY_DYNAMIC_DISPATCH(fit)(patch, then, place, brightness);
}

float mean_excess(GreyView image, int u, int v, GreyView then, const Eigen::Vector2f &place,
                  const Brightness &brightness) {
    return HWY_DYNAMIC_DISPATCH(excess)(image, u, v, then, place, brightness);
}

void claim_pixels(GreyView image, int u, int v, GreyView then, const Eigen::Vector2f &place,
                  const Brightness &brightness, std::int32_t owner, ImageView<float> least,
                  ImageView<std::int32_t> owners) {
    HWY_DYNAMIC_DISPATCH(claim)(image, u, v, then, place, brightness, owner, least, owners);
}

} // namespace afterglow
#endif
