// SPDX-License-Identifier: Apache-2.0
// Compiled once for each instruction set; the best of them is chosen when first called.
#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "core/base/pyramid.cpp"
#include "core/base/pyramid.hpp"

#include <algorithm>
#include <hwy/cache_control.h>
#include <hwy/foreach_target.h>
#include <hwy/highway.h>

// clang-format off: after Highway, once for each instruction set
#include "core/base/lanes-inl.hpp"
// clang-format on

HWY_BEFORE_NAMESPACE();
namespace afterglow::HWY_NAMESPACE {
namespace {

/// Two rows of twice `count` pixels to one of `count`.
void halve_bytes(const std::uint8_t *HWY_RESTRICT a, const std::uint8_t *HWY_RESTRICT b, int count,
                 Grey *HWY_RESTRICT out) {
    static_assert(grey_steps == 4 << 6); // of the sum of four bytes
    int u = 0;
#if HWY_TARGET != HWY_SCALAR // which has no vectors to part
    const hn::ScalableTag<std::uint8_t> bytes;
    const hn::RepartitionToWide<decltype(bytes)> d;
    const int lanes = static_cast<int>(hn::Lanes(d));
    const auto low = hn::Set(d, 0xff);
    // Two neighbours are the bytes of one 16-bit lane.
    const auto sum_of_two = [&](const std::uint8_t *from) HWY_ATTR {
        const auto two = hn::BitCast(d, hn::LoadU(bytes, from));
        return hn::Add(hn::And(two, low), hn::ShiftRight<8>(two));
    };
    for (; u + lanes <= count; u += lanes)
        hn::StoreU(hn::ShiftLeft<6>(hn::Add(sum_of_two(a + 2 * u), sum_of_two(b + 2 * u))), d,
                   out + u);
#endif
    for (; u < count; ++u)
        out[u] = static_cast<Grey>((a[2 * u] + a[2 * u + 1] + b[2 * u] + b[2 * u + 1]) << 6);
}

void halve_greys(const Grey *HWY_RESTRICT a, const Grey *HWY_RESTRICT b, int count,
                 Grey *HWY_RESTRICT out) {
    int u = 0;
#if HWY_TARGET != HWY_SCALAR
    const hn::ScalableTag<Grey> d;
    const int lanes = static_cast<int>(hn::Lanes(d));
    const auto of_rows = [&](int at) HWY_ATTR {
        return hn::AverageRound(hn::LoadU(d, a + at), hn::LoadU(d, b + at));
    };
    for (; u + lanes <= count; u += lanes) {
        const auto left = of_rows(2 * u), right = of_rows(2 * u + lanes);
        hn::StoreU(hn::AverageRound(hn::ConcatEven(d, right, left), hn::ConcatOdd(d, right, left)),
                   d, out + u);
    }
#endif
    const auto mean = [](int one, int other) { return (one + other + 1) / 2; };
    for (; u < count; ++u)
        out[u] =
            static_cast<Grey>(mean(mean(a[2 * u], b[2 * u]), mean(a[2 * u + 1], b[2 * u + 1])));
}

} // namespace
} // namespace afterglow::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace afterglow {
namespace {

HWY_EXPORT(halve_bytes);
HWY_EXPORT(halve_greys);

void halve(const std::uint8_t *a, const std::uint8_t *b, int count, Grey *out) {
    HWY_DYNAMIC_DISPATCH(halve_bytes)(a, b, count, out);
}

void halve(const Grey *a, const Grey *b, int count, Grey *out) {
    HWY_DYNAMIC_DISPATCH(halve_greys)(a, b, count, out);
}

} // namespace

Pyramid::Pyramid(int width, int height, int levels) {
    for (int l = 1; l <= levels; ++l)
        levels_.emplace_back(width >> l, height >> l);
}

/// Rows of level 1 that are halved at a time: a multiple of a row of the coarsest level.
int Pyramid::strip_rows() const {
    return std::max(16, 1 << (levels() - 1));
}

int Pyramid::strips() const {
    return (levels_.front().height() + strip_rows() - 1) / strip_rows();
}

void Pyramid::build(LumaView image) {
    for (int strip = 0; strip < strips(); ++strip)
        build_strip(image, strip);
}

void Pyramid::build(LumaView image, WorkerPool &pool) {
    pool.run(strips(), [&](int strip) { build_strip(image, strip); });
}

void Pyramid::build_strip(LumaView image, int strip) {
    const auto end_of = [&](const GreyImage &level, int rows) {
        return std::min((strip + 1) * rows, level.height());
    };
    GreyImage &first = levels_.front();
    for (int v = strip * strip_rows(); v < end_of(first, strip_rows()); ++v) {
        // The image comes from elsewhere, and is not in the cache.
        constexpr int rows_ahead = 8, line = static_cast<int>(cache_line);
        const int first_fetched = 2 * v + rows_ahead;
        for (int row = first_fetched; row < std::min(first_fetched + 2, image.height()); ++row)
            for (int u = 0; u < image.width(); u += line)
                hwy::Prefetch(image.row(row) + u);
        halve(image.row(2 * v), image.row(2 * v + 1), first.width(), first.row(v));
    }
    for (std::size_t l = 1; l < levels_.size(); ++l) {
        const GreyImage &from = levels_[l - 1];
        GreyImage &to = levels_[l];
        const int rows = strip_rows() >> l;
        for (int v = strip * rows; v < end_of(to, rows); ++v)
            halve(from.row(2 * v), from.row(2 * v + 1), to.width(), to.row(v));
    }
}

} // namespace afterglow
#endif
