// SPDX-License-Identifier: Apache-2.0
// Compiled once for each instruction set; the best of them is chosen when first called.
#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "core/base/pyramid.cpp"
#include "core/base/pyramid.hpp"

#include <hwy/foreach_target.h>
#include <hwy/highway.h>

// clang-format off: after Highway, once for each instruction set
#include "core/base/lanes-inl.hpp"
// clang-format on

HWY_BEFORE_NAMESPACE();
namespace afterglow::HWY_NAMESPACE {
namespace {

template <class T>
void halve_tail(const T *a, const T *b, int first, int count, float *out) {
    for (int u = first; u < count; ++u)
        out[u] = 0.25f * static_cast<float>(a[2 * u] + a[2 * u + 1] + b[2 * u] + b[2 * u + 1]);
}

/// Two rows of twice `count` pixels to one of `count`.
void halve_bytes(const std::uint8_t *HWY_RESTRICT a, const std::uint8_t *HWY_RESTRICT b, int count,
                 float *HWY_RESTRICT out) {
#if HWY_TARGET == HWY_SCALAR // has no vectors to part
    halve_tail(a, b, 0, count, out);
#else
    const hn::ScalableTag<std::uint8_t> bytes;
    const hn::RepartitionToWide<decltype(bytes)> d16;
    const hn::Half<decltype(d16)> half;
    const hn::Rebind<std::int32_t, decltype(half)> d32;
    const hn::Rebind<float, decltype(half)> d;
    const int lanes = static_cast<int>(hn::Lanes(d16)), whole = count - count % lanes;
    const auto low = hn::Set(d16, 0xff);
    const auto quarter = hn::Set(d, 0.25f);
    // Two neighbours are the bytes of one 16-bit lane.
    const auto sum_of_two = [&](const std::uint8_t *from) HWY_ATTR {
        const auto two = hn::BitCast(d16, hn::LoadU(bytes, from));
        return hn::Add(hn::And(two, low), hn::ShiftRight<8>(two));
    };
    const auto mean = [&](auto sums) HWY_ATTR {
        return hn::Mul(quarter, hn::ConvertTo(d, hn::PromoteTo(d32, sums)));
    };
    for (int u = 0; u < whole; u += lanes) {
        const auto sums = hn::Add(sum_of_two(a + 2 * u), sum_of_two(b + 2 * u));
        hn::StoreU(mean(hn::LowerHalf(half, sums)), d, out + u);
        hn::StoreU(mean(hn::UpperHalf(half, sums)), d, out + u + lanes / 2);
    }
    halve_tail(a, b, whole, count, out);
#endif
}

void halve_floats(const float *HWY_RESTRICT a, const float *HWY_RESTRICT b, int count,
                  float *HWY_RESTRICT out) {
    const hn::ScalableTag<float> d;
    const int lanes = static_cast<int>(hn::Lanes(d)), whole = count - count % lanes;
    const auto quarter = hn::Set(d, 0.25f);
    for (int u = 0; u < whole; u += lanes) {
        hn::Vec<decltype(d)> a0, a1, b0, b1;
        hn::LoadInterleaved2(d, a + 2 * u, a0, a1);
        hn::LoadInterleaved2(d, b + 2 * u, b0, b1);
        const auto sum = hn::Add(hn::Add(a0, a1), hn::Add(b0, b1));
        hn::StoreU(hn::Mul(quarter, sum), d, out + u);
    }
    halve_tail(a, b, whole, count, out);
}

} // namespace
} // namespace afterglow::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace afterglow {
namespace {

HWY_EXPORT(halve_bytes);
HWY_EXPORT(halve_floats);

void halve(const std::uint8_t *a, const std::uint8_t *b, int count, float *out) {
    HWY_DYNAMIC_DISPATCH(halve_bytes)(a, b, count, out);
}

void halve(const float *a, const float *b, int count, float *out) {
    HWY_DYNAMIC_DISPATCH(halve_floats)(a, b, count, out);
}

} // namespace

Pyramid::Pyramid(int width, int height, int levels) {
    for (int l = 1; l <= levels; ++l)
        levels_.emplace_back(width >> l, height >> l);
}

// All sums are exact: grey values of eight bits halved at most six times.
void Pyramid::build(LumaView image) {
    Image<float> &first = levels_[0];
    for (int v = 0; v < first.height(); ++v)
        halve(image.row(2 * v), image.row(2 * v + 1), first.width(), first.row(v));
    for (std::size_t l = 1; l < levels_.size(); ++l) {
        const Image<float> &from = levels_[l - 1];
        Image<float> &to = levels_[l];
        for (int v = 0; v < to.height(); ++v)
            halve(from.row(2 * v), from.row(2 * v + 1), to.width(), to.row(v));
    }
}

} // namespace afterglow
#endif
