// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstddef>
#include <span>

namespace afterglow {

/// Sums of weighted products of columns: J' W J and J' W e of a least squares problem with the
/// derivatives J, the weights W and the error e as the last column. Products are summed in single
/// precision within a call and in double precision from call to call. Real-time safe.
class WeightedProducts {
public:
    static constexpr int most_rows = 512; ///< of a call
    static constexpr int row_step = 64;   ///< they are a multiple of this
    static constexpr int most_columns = 12;

    void clear() { sums_.fill(0); }
    /// Adds sum over the rows of weight * column i * column j, for all first <= i <= j. `columns`:
    /// at most most_columns; all, and `weight`, have `rows` finite values. `first`: a multiple
    /// of 4.
    void add(std::span<const float *const> columns, const float *weight, int rows, int first = 0);
    /// The same for all i and the last column j alone.
    void add_with_last(std::span<const float *const> columns, const float *weight, int rows);
    void add(const WeightedProducts &other) {
        for (std::size_t i = 0; i < sums_.size(); ++i)
            sums_[i] += other.sums_[i];
    }
    /// Of columns i <= j.
    double operator()(int i, int j) const {
        return sums_[static_cast<std::size_t>(i) * most_columns + static_cast<std::size_t>(j)];
    }

private:
    std::array<double, most_columns * most_columns> sums_{};
};

} // namespace afterglow
