// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "tools/calibrate/board.hpp"

#include <opencv2/aruco.hpp>
#include <opencv2/aruco/charuco.hpp>

namespace afterglow {

/// Black bits around a tag of an AprilGrid: Kalibr prints two, where others have one.
inline constexpr int tag_border = 2;

inline cv::Ptr<cv::aruco::Dictionary> tags() {
    return cv::aruco::getPredefinedDictionary(cv::aruco::DICT_APRILTAG_36h11);
}
inline cv::Ptr<cv::aruco::CharucoBoard> charuco(const Board &board) {
    return cv::aruco::CharucoBoard::create(
        board.columns, board.rows, static_cast<float>(board.side_m),
        static_cast<float>(board.side_m * board.share),
        cv::aruco::getPredefinedDictionary(cv::aruco::DICT_5X5_250));
}

} // namespace afterglow
