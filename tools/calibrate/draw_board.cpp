// SPDX-License-Identifier: Apache-2.0
#include "tools/calibrate/board.hpp"
#include "tools/calibrate/markers.hpp"

#include <cmath>
#include <opencv2/imgproc.hpp>

namespace afterglow {
namespace {

int rounded(double value) {
    return static_cast<int>(std::lround(value));
}

/// A picture with a rim of one side around the pattern, whose top left corner places begin at.
struct Drawing {
    cv::Mat whole;
    int side;

    cv::Mat square(double left, double top, double length) const {
        return whole(
            cv::Rect(cv::Point(rounded(left) + side, rounded(top) + side),
                     cv::Point(rounded(left + length) + side, rounded(top + length) + side)));
    }
};

void draw_chessboard(const Board &board, const Drawing &drawing) {
    for (int row = 0; row < board.rows; ++row)
        for (int column = row % 2; column < board.columns; column += 2)
            drawing.square(column * drawing.side, row * drawing.side, drawing.side).setTo(0);
}

/// As Kalibr's kalibr_create_target_pdf does: tag 0 at the bottom left, and a black square where
/// the corners of four tags meet.
void draw_aprilgrid(const Board &board, const Drawing &drawing) {
    const double gap = board.share * drawing.side, pitch = drawing.side + gap;
    for (int row = 0; row <= board.rows; ++row)
        for (int column = 0; column <= board.columns; ++column)
            drawing.square(column * pitch - gap, row * pitch - gap, gap).setTo(0);
    for (int row = 0; row < board.rows; ++row) {
        for (int column = 0; column < board.columns; ++column) {
            cv::Mat tag;
            cv::aruco::drawMarker(tags(), (board.rows - 1 - row) * board.columns + column,
                                  drawing.side, tag, tag_border);
            tag.copyTo(drawing.square(column * pitch, row * pitch, drawing.side));
        }
    }
}

void draw_charuco(const Board &board, const Drawing &drawing) {
    cv::Mat pattern;
    charuco(board)->draw({board.columns * drawing.side, board.rows * drawing.side}, pattern);
    pattern.copyTo(drawing.whole(cv::Rect({drawing.side, drawing.side}, pattern.size())));
}

} // namespace

Luma draw_board(const Board &board, int side_px) {
    const Eigen::Vector2d size = board.size_m() / board.side_m * side_px;
    Luma luma(rounded(size.x()) + 2 * side_px, rounded(size.y()) + 2 * side_px, 255);
    const Drawing drawing{{luma.height(), luma.width(), CV_8UC1, luma.pixels().data()}, side_px};
    switch (board.kind) {
    case BoardKind::chessboard:
        draw_chessboard(board, drawing);
        break;
    case BoardKind::charuco:
        draw_charuco(board, drawing);
        break;
    case BoardKind::aprilgrid:
        draw_aprilgrid(board, drawing);
        break;
    }
    return luma;
}

} // namespace afterglow
