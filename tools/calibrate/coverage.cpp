// SPDX-License-Identifier: Apache-2.0
#include "tools/calibrate/coverage.hpp"

#include <algorithm>
#include <cmath>

namespace afterglow {

void Coverage::add(const Corners &corners) {
    for (const Eigen::Vector2d &pixel : corners.pixels) {
        const int column = static_cast<int>(std::floor(pixel.x() * columns / width_));
        const int row = static_cast<int>(std::floor(pixel.y() * rows / height_));
        if (column >= 0 && row >= 0 && column < columns && row < rows)
            seen_(column, row) = 1;
    }
}

double Coverage::share() const {
    return static_cast<double>(std::ranges::count(seen_.pixels(), 1)) / (columns * rows);
}

std::string Coverage::text(const std::string &indent) const {
    std::string text;
    for (int row = 0; row < rows; ++row) {
        text += indent;
        for (int column = 0; column < columns; ++column)
            text += seen(column, row) ? '#' : '.';
        text += '\n';
    }
    return text;
}

} // namespace afterglow
