// SPDX-License-Identifier: Apache-2.0
#include "tools/calibrate/find_board.hpp"

#include "core/base/median.hpp"
#include "tools/calibrate/markers.hpp"
#include "tools/picture/opencv_image.hpp"

#include <algorithm>
#include <cmath>
#include <opencv2/calib3d.hpp>
#include <opencv2/imgproc.hpp>
#include <utility>

namespace afterglow {
namespace {

using Points = std::vector<cv::Point2f>;

constexpr std::size_t fewest_corners = 12;
/// Pictures narrower than this are enlarged first: the detectors want squares of many pixels.
constexpr int wide_enough = 480;

/// Mean luma of the 3x3 pixels there.
double brightness(const cv::Mat &image, const cv::Point2f &at) {
    cv::Mat patch;
    cv::getRectSubPix(image, {3, 3}, at, patch);
    return cv::mean(patch)[0];
}

/// Puts the corners in the order of Board::corners(): OpenCV may begin at either end of a
/// chessboard. Its top left square is black.
void turn_upright(const cv::Mat &image, int columns, Points &corners) {
    const auto at = [&](int column, int row) {
        const int place = row * columns + column;
        return corners[static_cast<std::size_t>(place)];
    };
    const int rows = static_cast<int>(corners.size()) / columns;
    const cv::Point2f right = at(1, 0) - at(0, 0), down = at(0, 1) - at(0, 0);
    if (right.cross(down) < 0) // mirrored
        for (int row = 0; row < rows; ++row)
            std::reverse(corners.begin() + row * columns, corners.begin() + (row + 1) * columns);
    // The square right of and below the first corner has the colour of the top left one.
    const auto middle = [&](int column) {
        return 0.25F * (at(column, 0) + at(column + 1, 0) + at(column, 1) + at(column + 1, 1));
    };
    if (brightness(image, middle(0)) > brightness(image, middle(1)))
        std::reverse(corners.begin(), corners.end());
}

Points find_chessboard(const Board &board, const cv::Mat &image) {
    const cv::Size size(board.columns - 1, board.rows - 1);
    Points corners;
    if (!cv::findChessboardCornersSB(image, size, corners, cv::CALIB_CB_EXHAUSTIVE))
        return {};
    turn_upright(image, size.width, corners);
    return corners;
}

struct Marked {
    std::vector<int> numbers;
    Points pixels;
};

Marked find_charuco(const Board &board, const cv::Mat &image) {
    const auto pattern = charuco(board);
    std::vector<Points> markers, rejected;
    std::vector<int> ids;
    cv::aruco::detectMarkers(image, pattern->dictionary, markers, ids,
                             cv::aruco::DetectorParameters::create(), rejected);
    if (ids.size() < 2)
        return {};
    Marked found;
    cv::aruco::interpolateCornersCharuco(markers, ids, image, pattern, found.pixels, found.numbers);
    return found;
}

/// Which of the four corners of a tag comes first differs between printers of tags: where the
/// others are tells it.
Marked find_aprilgrid(const Board &board, const cv::Mat &image) {
    const auto parameters = cv::aruco::DetectorParameters::create();
    parameters->markerBorderBits = tag_border;
    parameters->cornerRefinementMethod = cv::aruco::CORNER_REFINE_SUBPIX;
    std::vector<Points> seen, rejected;
    std::vector<int> ids;
    cv::aruco::detectMarkers(image, tags(), seen, ids, parameters, rejected);
    const std::vector<Eigen::Vector2d> places = board.corners();
    Points centres_on_board, centres;
    for (std::size_t i = 0; i < ids.size(); ++i) {
        const auto first = static_cast<std::size_t>(ids[i]) * 4;
        if (first >= places.size())
            continue;
        const Eigen::Vector2d centre = (places[first] + places[first + 2]) / 2;
        centres_on_board.emplace_back(static_cast<float>(centre.x()),
                                      static_cast<float>(centre.y()));
        centres.push_back((seen[i][0] + seen[i][1] + seen[i][2] + seen[i][3]) / 4);
    }
    if (centres.size() < 4)
        return {};
    const cv::Mat homography = cv::findHomography(centres_on_board, centres, cv::RANSAC, 10);
    if (homography.empty())
        return {};
    Marked found;
    for (std::size_t i = 0; i < ids.size(); ++i) {
        for (std::size_t k = 0; k < 4; ++k) {
            const std::size_t number = static_cast<std::size_t>(ids[i]) * 4 + k;
            if (number >= places.size())
                continue;
            Points expected;
            cv::perspectiveTransform(Points{{static_cast<float>(places[number].x()),
                                             static_cast<float>(places[number].y())}},
                                     expected, homography);
            const auto nearest =
                std::min_element(seen[i].begin(), seen[i].end(), [&](const auto &a, const auto &b) {
                    return cv::norm(a - expected[0]) < cv::norm(b - expected[0]);
                });
            found.numbers.push_back(static_cast<int>(number));
            found.pixels.push_back(*nearest);
        }
    }
    return found;
}

/// How far around a corner there is nothing but its four squares, as a share of the distance to
/// the nearest other corner.
double plain_around(const Board &board) {
    return board.kind == BoardKind::charuco ? 0.4 * (1 - board.share) : 0.3;
}

/// To the saddle of each corner, in the picture as it is.
void refine(const cv::Mat &image, double plain, Points &corners) {
    double nearest = image.cols; // two corners to each other
    for (std::size_t i = 0; i < corners.size(); ++i)
        for (std::size_t k = 0; k < i; ++k)
            nearest = std::min(nearest, cv::norm(corners[i] - corners[k]));
    const int window = std::clamp(static_cast<int>(nearest * plain), 2, 5);
    Points refined = corners;
    if (!refined.empty())
        cv::cornerSubPix(image, refined, {window, window}, {-1, -1},
                         {cv::TermCriteria::EPS + cv::TermCriteria::MAX_ITER, 40, 0.001});
    for (std::size_t i = 0; i < corners.size(); ++i)
        if (cv::norm(refined[i] - corners[i]) < 1)
            corners[i] = refined[i];
}

} // namespace

Corners find_board(const Board &board, LumaView image) {
    const int scale = std::max(1, (wide_enough + image.width() - 1) / image.width());
    cv::Mat enlarged = as_mat(image);
    if (scale > 1)
        cv::resize(enlarged, enlarged, {}, scale, scale, cv::INTER_CUBIC);
    Marked found;
    switch (board.kind) {
    case BoardKind::chessboard:
        found.pixels = find_chessboard(board, enlarged);
        for (int i = 0; i < static_cast<int>(found.pixels.size()); ++i)
            found.numbers.push_back(i);
        break;
    case BoardKind::charuco:
        found = find_charuco(board, enlarged);
        break;
    case BoardKind::aprilgrid:
        found = find_aprilgrid(board, enlarged);
        break;
    }
    if (board.kind != BoardKind::chessboard && found.pixels.size() < fewest_corners)
        return {};
    Corners corners;
    corners.numbers = std::move(found.numbers);
    for (cv::Point2f &pixel : found.pixels) // of pixel centres, whatever the scale
        pixel = {(pixel.x + 0.5F) / scale - 0.5F, (pixel.y + 0.5F) / scale - 0.5F};
    refine(as_mat(image), plain_around(board), found.pixels);
    for (const cv::Point2f &pixel : found.pixels)
        corners.pixels.emplace_back(pixel.x, pixel.y);
    return corners;
}

double edge_width(const Corners &corners, LumaView image) {
    std::vector<double> widths;
    for (std::size_t i = 0; i < corners.size(); ++i) {
        double nearest = 40; // to another corner, pixels
        for (std::size_t k = 0; k < corners.size(); ++k)
            if (k != i)
                nearest = std::min(nearest, (corners.pixels[k] - corners.pixels[i]).norm());
        const int radius = std::max(2, static_cast<int>(nearest / 2));
        const int u0 = static_cast<int>(corners.pixels[i].x()),
                  v0 = static_cast<int>(corners.pixels[i].y());
        int darkest = 255, brightest = 0;
        double steepest = 1;
        for (int v = std::max(v0 - radius, 1); v < std::min(v0 + radius, image.height() - 1); ++v) {
            for (int u = std::max(u0 - radius, 1); u < std::min(u0 + radius, image.width() - 1);
                 ++u) {
                darkest = std::min<int>(darkest, image(u, v));
                brightest = std::max<int>(brightest, image(u, v));
                steepest = std::max(steepest, std::hypot(image(u + 1, v) - image(u - 1, v),
                                                         image(u, v + 1) - image(u, v - 1)) /
                                                  2);
            }
        }
        widths.push_back((brightest - darkest) / steepest);
    }
    return median(std::move(widths));
}

Luma to_luma(ImageView<const std::uint16_t> amplitude) {
    std::vector<std::uint16_t> sorted;
    for (int v = 0; v < amplitude.height(); ++v)
        sorted.insert(sorted.end(), amplitude.row(v), amplitude.row(v) + amplitude.width());
    Luma luma(amplitude.width(), amplitude.height());
    if (sorted.empty())
        return luma;
    const auto bright = sorted.begin() + static_cast<std::ptrdiff_t>(sorted.size() * 99 / 100);
    std::nth_element(sorted.begin(), bright, sorted.end());
    const double scale = 255 / std::sqrt(std::max<double>(*bright, 1));
    for (int v = 0; v < luma.height(); ++v)
        for (int u = 0; u < luma.width(); ++u)
            luma(u, v) = static_cast<std::uint8_t>(
                std::min(255.0, scale * std::sqrt(static_cast<double>(amplitude(u, v))) + 0.5));
    return luma;
}

} // namespace afterglow
