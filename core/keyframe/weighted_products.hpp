// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstddef>
#include <span>

namespace afterglow {

/// Sums of weighted products of columns: J' W J and J' W e of a least squares problem with the
/// derivatives J, the weights W and the error e as the last column. Rows come in blocks. Products
/// are summed in single precision within a block and in double precision from block to block.
/// Real-time safe.
class WeightedProducts {
public:
    static constexpr int rows = 64; ///< of a block
    static constexpr int most_columns = 12;

    void clear() { sums_.fill(0); }
    /// Adds sum over the rows of weight * column i * column j, for all first <= i <= j. `columns`:
    /// at most most_columns; all, and `weight`, have `rows` finite values. `first`: a multiple
    /// of 4.
    void add(std::span<const float *const> columns, const float *weight, int first = 0);
    /// The same for all i and the last column j alone.
    void add_with_last(std::span<const float *const> columns, const float *weight);
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
