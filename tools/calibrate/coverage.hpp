// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "core/base/image.hpp"
#include "tools/calibrate/find_board.hpp"

#include <cstdint>
#include <string>

namespace afterglow {

/// In which parts of a camera's picture corners have been seen: a grid of cells.
class Coverage {
public:
    static constexpr int columns = 8;
    static constexpr int rows = 6;

    /// Of a picture of `width` x `height` pixels.
    Coverage(int width, int height) : width_(width), height_(height) {}

    void add(const Corners &corners);
    /// Cells with corners, as a share of all.
    double share() const;
    bool seen(int column, int row) const { return seen_(column, row) != 0; }
    /// A line for each row of cells: '#' where corners were seen, '.' where none were.
    std::string text(const std::string &indent) const;

private:
    int width_, height_;
    Image<std::uint8_t> seen_{columns, rows}; ///< 1 where corners were
};

} // namespace afterglow
