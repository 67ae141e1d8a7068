// SPDX-License-Identifier: Apache-2.0
#include "eval/baselines/keypoints.hpp"

#include "tools/picture/opencv_image.hpp"

#include <algorithm>
#include <dlib/array2d.h>
#include <dlib/image_keypoint.h>
#include <dlib/pixel.h>
#include <opencv2/features2d.hpp>

namespace afterglow {
namespace {

Keypoints find_keypoints(cv::Feature2D &finder, LumaView image) {
    std::vector<cv::KeyPoint> found;
    Keypoints keypoints;
    finder.detectAndCompute(as_mat(image), cv::noArray(), found, keypoints.descriptors);
    cv::KeyPoint::convert(found, keypoints.pixels);
    return keypoints;
}

} // namespace

Keypoints find_sift_keypoints(LumaView image) {
    return find_keypoints(*cv::SIFT::create(), image);
}

Keypoints find_orb_keypoints(LumaView image) {
    return find_keypoints(*cv::ORB::create(), image);
}

Keypoints find_surf_keypoints(LumaView image) {
    dlib::array2d<unsigned char> pixels(image.height(), image.width());
    for (int v = 0; v < image.height(); ++v)
        std::copy_n(image.row(v), image.width(), &pixels[v][0]);
    const std::vector<dlib::surf_point> found = dlib::get_surf_points(pixels);
    Keypoints keypoints;
    keypoints.descriptors.create(static_cast<int>(found.size()), 64, CV_32F);
    for (std::size_t i = 0; i < found.size(); ++i) {
        const auto &centre = found[i].p.center;
        keypoints.pixels.emplace_back(static_cast<float>(centre.x()),
                                      static_cast<float>(centre.y()));
        std::copy(found[i].des.begin(), found[i].des.end(),
                  keypoints.descriptors.ptr<float>(static_cast<int>(i)));
    }
    return keypoints;
}

std::vector<PixelPair> match_keypoints(const Keypoints &from, const Keypoints &to) {
    constexpr float clearly = 0.8f; // nearer than the second nearest (Lowe 2004, Section 7.1)
    if (from.pixels.empty() || to.pixels.empty())
        return {};
    const int norm = from.descriptors.type() == CV_8U ? cv::NORM_HAMMING : cv::NORM_L2;
    std::vector<std::vector<cv::DMatch>> nearest;
    cv::BFMatcher(norm).knnMatch(from.descriptors, to.descriptors, nearest, 2);
    std::vector<PixelPair> pairs;
    for (const auto &two : nearest)
        if (two.size() == 2 && two[0].distance < clearly * two[1].distance)
            pairs.push_back({from.pixels[static_cast<std::size_t>(two[0].queryIdx)],
                             to.pixels[static_cast<std::size_t>(two[0].trainIdx)]});
    return pairs;
}

} // namespace afterglow
