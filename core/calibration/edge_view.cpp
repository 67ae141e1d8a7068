// SPDX-License-Identifier: Apache-2.0
#include "core/calibration/edge_view.hpp"

#include "core/base/camera.hpp"

#include <Eigen/Geometry>

#include <algorithm>
#include <cassert>
#include <cmath>

namespace afterglow {
namespace {

constexpr float noise = 3;          ///< grey values: a weaker step is no edge
constexpr float strongest = 3;      ///< share; an edge counts for no more
constexpr int surroundings = 5;     ///< pixels to either side that an edge must surpass
constexpr double farthest_px = 1e6; ///< no camera moves so fast that an edge would go so far in 1 s

/// The image's grey value between pixels; negative outside.
float sample(ImageView<const std::uint8_t> image, float u, float v) {
    if (!(u >= 0 && v >= 0 && u < static_cast<float>(image.width() - 1) &&
          v < static_cast<float>(image.height() - 1)))
        return -1;
    const int x = static_cast<int>(u), y = static_cast<int>(v);
    const float a = u - static_cast<float>(x), b = v - static_cast<float>(y);
    const std::uint8_t *above = image.row(y) + x, *below = image.row(y + 1) + x;
    const float top = above[0] + a * static_cast<float>(above[1] - above[0]);
    const float bottom = below[0] + a * static_cast<float>(below[1] - below[0]);
    return top + b * (bottom - top);
}

/// Calls `use(s, mean)` with the mean of `values` around each place s of a profile.
template <std::size_t length, class Use>
void around(const std::array<float, length> &values, const Use &use) {
    constexpr int n = static_cast<int>(length);
    float sum = 0;
    for (int s = 0; s < surroundings; ++s)
        sum += values[static_cast<std::size_t>(s)];
    for (int s = 0; s < n; ++s) {
        const int first = std::max(s - surroundings, 0);
        const int last = std::min(s + surroundings, n - 1);
        if (s + surroundings < n)
            sum += values[static_cast<std::size_t>(last)];
        if (s > surroundings)
            sum -= values[static_cast<std::size_t>(first - 1)];
        use(static_cast<std::size_t>(s), sum / static_cast<float>(last - first + 1));
    }
}

Eigen::Vector2d centre(const Intrinsics &camera) {
    return {camera.cx, camera.cy};
}

int tile_of(const Eigen::Vector2d &place, const Intrinsics &camera) {
    const auto along = [](double at, int size, int tiles) {
        return std::clamp(static_cast<int>(at * tiles / size), 0, tiles - 1);
    };
    return along(place.y(), camera.height, EdgeEvidence::rows) * EdgeEvidence::columns +
           along(place.x(), camera.width, EdgeEvidence::columns);
}

} // namespace

EdgeKernel::EdgeKernel(double spread)
    : reach_(std::min(static_cast<int>(std::ceil(2.5 * spread)), radius)) {
    double sum = 0, squares = 0;
    for (std::size_t p = 0; p < places; ++p)
        for (int s = -reach_; s <= reach_; ++s) {
            const double d = s - (static_cast<double>(p) + 0.5) / places;
            const double w = std::exp(-0.5 * d * d / (spread * spread));
            const int at = s + radius;
            weights_[p][static_cast<std::size_t>(at)] = static_cast<float>(w);
            sum += w;
            squares += w * d * d;
        }
    variance_ = static_cast<float>(squares / sum);
}

EdgeView::EdgeView(const Intrinsics &camera, int capacity)
    : camera_(camera), image_(camera.width, camera.height) {
    edges_.reserve(static_cast<std::size_t>(capacity));
}

void EdgeView::take(std::span<const DepthEdge> edges, GreyView image, const Twist &rate) {
    assert(image.same_size(image_.view()) && edges.size() <= edges_.capacity());
    for (int v = 0; v < image.height(); ++v)
        std::transform(image.row(v), image.row(v) + image.width(), image_.row(v), [](Grey grey) {
            return static_cast<std::uint8_t>((grey + grey_steps / 2) / grey_steps);
        });
    looked_ = false;
    edges_.clear();
    sensitivity_.setZero();
    for (const DepthEdge &edge : edges) {
        const Eigen::Vector3d X = edge.at.cast<double>(), beyond = edge.beyond.cast<double>();
        if (!(X.z() > nearest_seen_m && beyond.z() > nearest_seen_m))
            continue;
        const Eigen::Vector2d at = camera_.project(X), from_centre = at - centre(camera_);
        const Eigen::Vector2d n = (camera_.project(beyond) - at).normalized();
        const Eigen::Vector3d by_X{n.x() * camera_.fx / X.z(), n.y() * camera_.fy / X.z(),
                                   -n.dot(from_centre) / X.z()};
        RigError by_error;
        by_error << X.cross(by_X), by_X, n.dot(from_centre),
            -by_X.dot(rate.head<3>() + rate.tail<3>().cross(X)), 1;
        if (!(by_error.norm() < farthest_px))
            continue;
        Edge &seen = edges_.emplace_back();
        seen.at = edge.at;
        seen.across = n.cast<float>();
        seen.by_error = by_error.cast<float>();
        seen.tile = tile_of(at, camera_);
        sensitivity_.noalias() += seen.by_error * seen.by_error.transpose();
    }
}

void EdgeView::look(const RigError &error) {
    constexpr float near_px = 1.5f;
    const Eigen::Matrix<float, 9, 1> step = (error - base_).cast<float>();
    float squares = 0;
    for (const Edge &edge : edges_)
        squares += edge.by_error.dot(step) * edge.by_error.dot(step);
    if (looked_ && squares <= near_px * near_px * static_cast<float>(size()))
        return;
    base_ = error;
    looked_ = true;
    for (Edge &edge : edges_)
        look_across(edge);
    // What all edges have in common at some distance, as patterns on the near surfaces, says
    // nothing.
    Profile common{};
    for (const Edge &edge : edges_)
        for (std::size_t s = 0; s < common.size(); ++s)
            common[s] += edge.profile[s];
    Profile mean{};
    around(common, [&](std::size_t s, float sum) { mean[s] = sum / static_cast<float>(size()); });
    for (Edge &edge : edges_)
        for (std::size_t s = 0; s < mean.size(); ++s)
            edge.profile[s] -= mean[s];
}

/// Notes by which share the image's gradient along the line surpasses that of its surroundings.
void EdgeView::look_across(Edge &edge) const {
    using namespace rig_error;
    edge.profile.fill(0);
    const Eigen::Vector3d X = edge.at.cast<double>();
    const Eigen::Vector3d moved =
        X + base_.segment<3>(displacement) + base_.segment<3>(turn).cross(X);
    if (!(moved.z() > nearest_seen_m))
        return;
    const Eigen::Vector2f along =
        static_cast<float>(edge.by_error[lag] * base_[lag] + base_[margin]) * edge.across;
    const Eigen::Vector2f place =
        (centre(camera_) + (1 + base_[focal]) * (camera_.project(moved) - centre(camera_)))
            .cast<float>() +
        along;
    std::array<float, length + 2> grey{};
    for (std::size_t s = 0; s < grey.size(); ++s) {
        const Eigen::Vector2f at = place + (static_cast<float>(s) - reach - 1) * edge.across;
        grey[s] = sample(image_, at.x(), at.y());
    }
    Profile gradient{};
    for (std::size_t s = 0; s < gradient.size(); ++s)
        gradient[s] = grey[s] < 0 || grey[s + 1] < 0 || grey[s + 2] < 0
                          ? 0.0f
                          : 0.5f * std::abs(grey[s + 2] - grey[s]);
    around(gradient, [&](std::size_t s, float mean) {
        edge.profile[s] = std::clamp(gradient[s] / (mean + noise) - 1, 0.0f, strongest);
    });
}

/// The mean c of the places near an edge, weighted by kernel K and profile q, is off by r = c - x
/// where x is what is sought, and dr/dx = V / V_K - 1 with the variances of K q and K: a
/// profile without a peak says nothing.
void EdgeView::gather(const RigError &error, const EdgeKernel &kernel,
                      EdgeEvidence &evidence) const {
    const Eigen::Matrix<float, 9, 1> step = (error - base_).cast<float>();
    const int around = kernel.reach();
    for (const Edge &edge : edges_) {
        const float x = edge.by_error.dot(step) + reach;
        if (!(x >= static_cast<float>(around) && x < static_cast<float>(length - 1 - around)))
            continue;
        const int below = static_cast<int>(x);
        const float part = x - static_cast<float>(below);
        const float *weights =
            kernel.at(static_cast<int>(part * EdgeKernel::places)) + EdgeKernel::radius;
        const float *profile = edge.profile.data() + below;
        float sum = 0, moment = 0, squares = 0, score = 0;
        for (int s = -around; s <= around; ++s) {
            const float q = weights[s] * std::max(profile[s], 0.0f), d = static_cast<float>(s);
            score += weights[s] * profile[s];
            sum += q;
            moment += q * d;
            squares += q * d * d;
        }
        evidence.score[edge.tile] += score;
        if (sum < 0.1f)
            continue;
        const float mean = moment / sum;
        const float slope = 1 - (squares / sum - mean * mean) / kernel.variance();
        if (slope <= 0)
            continue;
        const float trust = slope * sum / (sum + 1);
        evidence.g.col(edge.tile) += trust * (mean - part) * edge.by_error;
        evidence.H.noalias() += (trust * slope) * edge.by_error * edge.by_error.transpose();
    }
}

Eigen::Vector2i EdgeView::scan(const RigError &error, const RigError &a, const RigError &b, int n,
                               int every) const {
    const int side = 2 * n + 1;
    std::array<float, widest_scan * widest_scan> scores{};
    const Eigen::Matrix<float, 9, 1> step = (error - base_).cast<float>();
    for (std::size_t i = 0; i < edges_.size(); i += static_cast<std::size_t>(every)) {
        const Edge &edge = edges_[i];
        const float at = edge.by_error.dot(step) + reach + 0.5f;
        const float by_a = edge.by_error.dot(a.cast<float>());
        const float by_b = edge.by_error.dot(b.cast<float>());
        float *score = scores.data();
        for (int j = -n; j <= n; ++j)
            for (int k = -n; k <= n; ++k, ++score) {
                const float x = at + static_cast<float>(k) * by_a + static_cast<float>(j) * by_b;
                if (!(x >= 1 && x < length - 1))
                    continue;
                const float *profile = edge.profile.data() + static_cast<int>(x);
                *score += profile[0] + 0.5f * (profile[-1] + profile[1]);
            }
    }
    const auto most = std::max_element(scores.begin(), scores.begin() + side * side);
    const int place = static_cast<int>(most - scores.begin());
    return {place % side - n, place / side - n};
}

} // namespace afterglow
