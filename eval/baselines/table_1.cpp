// SPDX-License-Identifier: Apache-2.0
#include "eval/baselines/table_1.hpp"

#include "tools/picture/opencv_image.hpp"

#include <opencv2/imgproc.hpp>
#include <opencv2/video/tracking.hpp>

namespace afterglow {

void find_lucas_kanade_flow(const EstimatorOptions::Flow &options, LumaView previous, LumaView next,
                            std::vector<Match> &matches) {
    if (matches.empty())
        return;
    constexpr int coarsest_level = 2; // of 0, 1, 2
    std::vector<cv::Point2f> from;
    for (const Match &match : matches)
        from.emplace_back(static_cast<float>(match.from.x()), static_cast<float>(match.from.y()));
    std::vector<cv::Point2f> to;
    std::vector<std::uint8_t> found;
    cv::calcOpticalFlowPyrLK(as_mat(previous), as_mat(next), from, to, found, cv::noArray(),
                             cv::Size(options.block, options.block), coarsest_level);
    std::size_t kept = 0;
    for (std::size_t i = 0; i < matches.size(); ++i) {
        if (!found[i])
            continue;
        matches[kept] = matches[i];
        matches[kept++].to = {to[i].x, to[i].y};
    }
    matches.erase(matches.begin() + static_cast<std::ptrdiff_t>(kept), matches.end());
}

std::vector<Eigen::Vector2f> find_harris_corners(LumaView image, int most) {
    constexpr double least_quality = 0.01; // of the strongest corner's
    constexpr double least_distance = 10;  // pixels
    constexpr int block = 3;
    constexpr double k = 0.04;
    std::vector<cv::Point2f> found;
    cv::goodFeaturesToTrack(as_mat(image), found, most, least_quality, least_distance,
                            cv::noArray(), block, true, k);
    std::vector<Eigen::Vector2f> corners;
    for (const cv::Point2f &corner : found)
        corners.emplace_back(corner.x, corner.y);
    return corners;
}

} // namespace afterglow
