// SPDX-License-Identifier: Apache-2.0
// Compiled once for each instruction set; the best of them is chosen when first called.
#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "core/keyframe/steepest_gradients.cpp"
#include "core/keyframe/steepest_gradients.hpp"

#include <hwy/foreach_target.h>
#include <hwy/highway.h>

// clang-format off: after Highway, once for each instruction set
#include "core/base/lanes-inl.hpp"
// clang-format on

HWY_BEFORE_NAMESPACE();
namespace afterglow::HWY_NAMESPACE {
namespace {

void steepest(ImageView<const float> image, int first_row, int end_row, float *steepness,
              int *rows) {
    const float *const pixels = image.data();
    const int stride = image.stride();
    for_lanes(image.width() - 2, [&](auto d, int i) HWY_ATTR {
        const hn::RebindToSigned<decltype(d)> di;
        const auto half = hn::Set(d, 0.5f);
        auto most = hn::Zero(d);
        auto at = hn::Set(di, first_row);
        const float *here = pixels + first_row * stride + i + 1;
        for (int row = first_row; row < end_row; ++row, here += stride) {
            const auto gx = hn::Mul(half, hn::Sub(hn::LoadU(d, here + 1), hn::LoadU(d, here - 1)));
            const auto gy =
                hn::Mul(half, hn::Sub(hn::LoadU(d, here + stride), hn::LoadU(d, here - stride)));
            const auto squared = hn::Add(hn::Mul(gx, gx), hn::Mul(gy, gy));
            const auto steeper = hn::Gt(order(d, squared), order(d, most));
            most = hn::Max(squared, most);
            at = hn::IfThenElse(steeper, hn::Set(di, row), at);
        }
        hn::StoreU(most, d, steepness + i + 1);
        hn::StoreU(at, di, rows + i + 1);
    });
}

} // namespace
} // namespace afterglow::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace afterglow {
namespace {

HWY_EXPORT(steepest);

} // namespace

void find_steepest(ImageView<const float> image, int first_row, int end_row,
                   std::span<float> steepness, std::span<int> rows) {
    HWY_DYNAMIC_DISPATCH(steepest)(image, first_row, end_row, steepness.data(), rows.data());
}

} // namespace afterglow
#endif
