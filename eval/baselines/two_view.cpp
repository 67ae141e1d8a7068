// SPDX-License-Identifier: Apache-2.0
#include "eval/baselines/two_view.hpp"

#include "core/base/median.hpp"
#include "tools/picture/opencv_image.hpp"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <limits>
#include <opencv2/calib3d.hpp>
#include <utility>

namespace afterglow {
namespace {

/// The 8-point algorithm needs as many.
constexpr std::size_t least_pairs = 8;

/// A point is dropped when it lies so many times further than the median: its rays are all but
/// parallel, and where they meet is chance.
constexpr double far = 3;

/// The pairs of which `mask` holds something but 0.
void keep(std::vector<cv::Point2f> &from, std::vector<cv::Point2f> &to,
          const std::vector<std::uint8_t> &mask) {
    std::size_t kept = 0;
    for (std::size_t i = 0; i < mask.size(); ++i) {
        if (mask[i] == 0)
            continue;
        from[kept] = from[i];
        to[kept++] = to[i];
    }
    from.resize(kept);
    to.resize(kept);
}

void drop_far(std::vector<ScenePoint> &points) {
    if (points.empty())
        return;
    std::vector<double> z;
    for (const ScenePoint &point : points)
        z.push_back(point.z);
    const double limit = far * median(std::move(z));
    std::erase_if(points, [&](const ScenePoint &point) { return point.z > limit; });
}

} // namespace

std::vector<ScenePoint> triangulate(std::span<const PixelPair> pairs, const Intrinsics &camera) {
    constexpr double tolerance = 0.25; // pixels from the epipolar line
    constexpr double certainty = 0.999;
    if (pairs.size() < least_pairs)
        return {};
    std::vector<cv::Point2f> from;
    std::vector<cv::Point2f> to;
    for (const PixelPair &pair : pairs) {
        from.push_back(pair.from);
        to.push_back(pair.to);
    }
    std::vector<std::uint8_t> mask;
    cv::findFundamentalMat(from, to, cv::FM_RANSAC, tolerance, certainty, mask);
    keep(from, to, mask);
    if (from.size() < least_pairs)
        return {};
    const cv::Mat F = cv::findFundamentalMat(from, to, cv::FM_8POINT);
    if (F.rows != 3 || !cv::checkRange(F))
        return {};

    const cv::Matx33d K = as_matrix(camera);
    const cv::Mat E = cv::Mat(K.t()) * F * cv::Mat(K);
    cv::Mat R;
    cv::Mat T;
    cv::Mat_<double> points; // homogeneous, a column for each pair
    constexpr double any_distance = std::numeric_limits<double>::max();
    mask.assign(from.size(), 1);
    cv::recoverPose(E, from, to, K, R, T, any_distance, mask, points);
    const cv::Mat_<double> axis = R.row(2);
    std::vector<ScenePoint> scene;
    for (int i = 0; i < points.cols; ++i) {
        const auto index = static_cast<std::size_t>(i);
        if (mask[index] == 0)
            continue;
        const double w = points(3, i);
        const double z =
            (axis(0) * points(0, i) + axis(1) * points(1, i) + axis(2) * points(2, i)) / w +
            cv::Mat_<double>(T)(2);
        if (z > 0 && std::isfinite(z))
            scene.push_back({{to[index].x, to[index].y}, z});
    }
    drop_far(scene);
    return scene;
}

std::optional<double> fit_scale(std::span<const ScenePoint> points, DepthView truth) {
    // The mean of |z - s z'| / z, with z the true and z' the scaled depth, is that of |r - s| for
    // ratios r = z / z' with weights z' / z: the least for their weighted median.
    struct Ratio {
        double ratio;
        double weight;
    };
    std::vector<Ratio> ratios;
    double total = 0;
    for (const ScenePoint &point : points) {
        const auto at = pixel_of(point, truth.width(), truth.height());
        if (!at || truth(at->x(), at->y()) == 0)
            continue;
        const double ratio = truth(at->x(), at->y()) / 1000.0 / point.z;
        ratios.push_back({ratio, 1 / ratio});
        total += 1 / ratio;
    }
    std::ranges::sort(ratios, {}, &Ratio::ratio);
    double below = 0;
    for (const auto &[ratio, weight] : ratios) {
        below += weight;
        if (2 * below >= total)
            return ratio;
    }
    return std::nullopt;
}

std::optional<Eigen::Vector2i> pixel_of(const ScenePoint &point, int width, int height) {
    const double u = std::round(point.pixel.x());
    const double v = std::round(point.pixel.y());
    if (!(u >= 0 && v >= 0 && u < width && v < height))
        return std::nullopt;
    return Eigen::Vector2i(static_cast<int>(u), static_cast<int>(v));
}

} // namespace afterglow
