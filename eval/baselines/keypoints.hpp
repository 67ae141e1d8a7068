// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "core/base/image.hpp"

#include <opencv2/core.hpp>
#include <vector>

namespace afterglow {

/// Points of an image that can be found again in another, and what they look like.
struct Keypoints {
    std::vector<cv::Point2f> pixels;
    cv::Mat descriptors; ///< a row for each; floats, or bits in bytes
};

/// Each with its library's own settings: OpenCV's, dlib's for SURF.
Keypoints find_sift_keypoints(LumaView image);
Keypoints find_surf_keypoints(LumaView image);
Keypoints find_orb_keypoints(LumaView image);

/// Two points of two images that show the same.
struct PixelPair {
    cv::Point2f from;
    cv::Point2f to;
};

/// By brute force: every keypoint of `from` with the one of `to` that is clearly the most like it.
std::vector<PixelPair> match_keypoints(const Keypoints &from, const Keypoints &to);

} // namespace afterglow
