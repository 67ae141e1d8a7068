// SPDX-License-Identifier: Apache-2.0
// Compiled once for each instruction set; the best of them is chosen when first called.
#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "core/alignment/weighted_products.cpp"
#include "core/alignment/weighted_products.hpp"

#include <hwy/foreach_target.h>
#include <hwy/highway.h>

// clang-format off: after Highway, once for each instruction set
#include "core/base/lanes-inl.hpp"
// clang-format on

#include <algorithm>
#include <cassert>
#include <cstddef>

HWY_BEFORE_NAMESPACE();
namespace afterglow::HWY_NAMESPACE {
namespace {

using Lanes = hn::CappedTag<float, WeightedProducts::row_step>;

/// Adds the products of two weighted columns with four others. Eight sums at a time: the registers
/// of the smallest targets hold them and what they are made of, and each value read is used twice
/// or four times.
HWY_INLINE void add_tile(const float *weighted0, const float *weighted1,
                         const float *const *columns, int rows, double *HWY_RESTRICT sums0,
                         double *HWY_RESTRICT sums1) {
    const Lanes d;
    const float *column0 = columns[0], *column1 = columns[1];
    const float *column2 = columns[2], *column3 = columns[3];
    auto s00 = hn::Zero(d), s01 = s00, s02 = s00, s03 = s00;
    auto s10 = s00, s11 = s00, s12 = s00, s13 = s00;
    for (const float *const end = weighted0 + rows; weighted0 != end;) {
        const auto w0 = load_next(d, weighted0), w1 = load_next(d, weighted1);
        const auto c0 = load_next(d, column0);
        s00 = hn::MulAdd(w0, c0, s00);
        s10 = hn::MulAdd(w1, c0, s10);
        const auto c1 = load_next(d, column1);
        s01 = hn::MulAdd(w0, c1, s01);
        s11 = hn::MulAdd(w1, c1, s11);
        const auto c2 = load_next(d, column2);
        s02 = hn::MulAdd(w0, c2, s02);
        s12 = hn::MulAdd(w1, c2, s12);
        const auto c3 = load_next(d, column3);
        s03 = hn::MulAdd(w0, c3, s03);
        s13 = hn::MulAdd(w1, c3, s13);
    }
    const auto add = [&](double &sum, auto lanes)
                         HWY_ATTR { sum += hn::GetLane(hn::SumOfLanes(d, lanes)); };
    add(sums0[0], s00);
    add(sums0[1], s01);
    add(sums0[2], s02);
    add(sums0[3], s03);
    add(sums1[0], s10);
    add(sums1[1], s11);
    add(sums1[2], s12);
    add(sums1[3], s13);
}

/// Adds to a square matrix of sums, row by row, the products of the columns first .. end - 1; both
/// are multiples of 4.
void add_products(const float *const *columns, int rows, int first, int end,
                  const float *HWY_RESTRICT weight, double *HWY_RESTRICT sums) {
    constexpr int width = WeightedProducts::most_columns;
    const Lanes d;
    HWY_ALIGN float weighted[2][WeightedProducts::most_rows];
    for (int i = first; i < end; i += 2) {
        const float *weights = weight, *column0 = columns[i], *column1 = columns[i + 1];
        for (int row = 0; row < rows; row += static_cast<int>(hn::Lanes(d))) {
            const auto w = load_next(d, weights);
            hn::Store(hn::Mul(w, load_next(d, column0)), d, weighted[0] + row);
            hn::Store(hn::Mul(w, load_next(d, column1)), d, weighted[1] + row);
        }
        for (int j = i / 4 * 4; j < end; j += 4)
            add_tile(weighted[0], weighted[1], columns + j, rows, sums + i * width + j,
                     sums + (i + 1) * width + j);
    }
}

/// The same for the products of all columns with column `last`.
void add_products_with(const float *const *columns, int rows, int last,
                       const float *HWY_RESTRICT weight, double *HWY_RESTRICT sums) {
    constexpr int width = WeightedProducts::most_columns;
    const Lanes d;
    HWY_ALIGN float weighted[WeightedProducts::most_rows];
    for (int row = 0; row < rows; row += static_cast<int>(hn::Lanes(d)))
        hn::Store(hn::Mul(hn::LoadU(d, weight + row), hn::LoadU(d, columns[last] + row)), d,
                  weighted + row);
    for (int i = 0; i <= last; i += 2) {
        const float *weights = weighted, *column0 = columns[i], *column1 = columns[i + 1];
        auto s0 = hn::Zero(d), s1 = s0;
        for (const float *const end = weights + rows; weights != end;) {
            const auto w = load_next(d, weights);
            s0 = hn::MulAdd(w, load_next(d, column0), s0);
            s1 = hn::MulAdd(w, load_next(d, column1), s1);
        }
        sums[i * width + last] += hn::GetLane(hn::SumOfLanes(d, s0));
        if (i < last)
            sums[(i + 1) * width + last] += hn::GetLane(hn::SumOfLanes(d, s1));
    }
}

} // namespace
} // namespace afterglow::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace afterglow {
namespace {

HWY_EXPORT(add_products);
HWY_EXPORT(add_products_with);

using Columns = std::array<const float *, WeightedProducts::most_columns>;

/// With columns of zeros to the end.
Columns padded(std::span<const float *const> columns) {
    static constexpr std::array<float, WeightedProducts::most_rows> nothing{};
    Columns all;
    all.fill(nothing.data());
    std::ranges::copy(columns, all.begin());
    return all;
}

} // namespace

void WeightedProducts::add(std::span<const float *const> columns, const float *weight, int rows,
                           int first) {
    assert(rows <= most_rows && rows % row_step == 0);
    const int end = (static_cast<int>(columns.size()) + 3) / 4 * 4;
    HWY_DYNAMIC_DISPATCH(add_products)
    (padded(columns).data(), rows, first, end, weight, sums_.data());
}

void WeightedProducts::add_with_last(std::span<const float *const> columns, const float *weight,
                                     int rows) {
    assert(rows <= most_rows && rows % row_step == 0);
    HWY_DYNAMIC_DISPATCH(add_products_with)
    (padded(columns).data(), rows, static_cast<int>(columns.size()) - 1, weight, sums_.data());
}

} // namespace afterglow
#endif
