// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "core/base/image.hpp"
#include "core/base/result.hpp"

#include <Eigen/Core>

#include <cstdint>
#include <string>
#include <vector>

namespace afterglow {

enum class BoardKind : std::uint8_t { chessboard, charuco, aprilgrid };

/// A flat pattern whose corners a camera finds. Places on it: metres from the top left corner of
/// the pattern, x right and y down as it hangs on a wall; the white rim around it does not count.
struct Board {
    BoardKind kind = BoardKind::chessboard;
    int columns = 0; ///< squares of a chessboard or ChArUco board, tags of an AprilGrid
    int rows = 0;
    double side_m = 0; ///< of a square, or of a tag
    /// ChArUco: side of a marker; AprilGrid: the gap between tags; both as a share of side_m.
    double share = 0;

    /// Their places, by number.
    std::vector<Eigen::Vector2d> corners() const;
    Eigen::Vector2d size_m() const;

    bool operator==(const Board &) const = default;
};

/// "chessboard:10x7:30", "charuco:10x7:30:0.75", "aprilgrid:6x6:30:0.3": kind, columns and rows,
/// side in millimetres, share. Errors: what is wrong with it, and what is allowed.
Result<Board> parse_board(const std::string &text);
std::string to_text(const Board &board);

/// The pattern and a white rim of one side around it, `side_px` pixels to a side.
Luma draw_board(const Board &board, int side_px);

} // namespace afterglow
