// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "core/base/image.hpp"
#include "tools/calibrate/board.hpp"

#include <Eigen/Core>

#include <vector>

namespace afterglow {

/// Corners of a board in a picture; both vectors have one length.
struct Corners {
    std::vector<int> numbers; ///< indices into Board::corners()
    std::vector<Eigen::Vector2d> pixels;

    bool empty() const { return numbers.empty(); }
    std::size_t size() const { return numbers.size(); }
};

/// The board's corners, to a few hundredths of a pixel; empty where it is not seen. A chessboard is
/// found as a whole, of the other boards twelve corners at least.
Corners find_board(const Board &board, LumaView image);

/// How wide the picture of a sharp edge is, pixels: the median over the corners, 1 to 3 in a sharp
/// picture. `corners`: of find_board(), not empty.
double edge_width(const Corners &corners, LumaView image);

/// A picture of 16 bits as find_board() likes it: square root, up to the brightest percent.
Luma to_luma(ImageView<const std::uint16_t> amplitude);

} // namespace afterglow
