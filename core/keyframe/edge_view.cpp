// SPDX-License-Identifier: Apache-2.0
#include "core/keyframe/edge_view.hpp"

#include <algorithm>
#include <array>
#include <cassert>
#include <cmath>

namespace afterglow {
namespace {

constexpr int reach = EdgeProfiles::reach, length = EdgeProfiles::length;
constexpr float noise = 3;      ///< grey values: a weaker step is no edge
constexpr float strongest = 3;  ///< share; an edge counts for no more
constexpr int surroundings = 5; ///< pixels to either side that an edge must surpass
constexpr double nearest_m = 0.05;

/// The image's grey value between pixels; negative outside.
float sample(ImageView<const std::uint8_t> image, double u, double v) {
    if (!(u >= 0 && v >= 0 && u < image.width() - 1 && v < image.height() - 1))
        return -1;
    const int x = static_cast<int>(u), y = static_cast<int>(v);
    const float a = static_cast<float>(u - x), b = static_cast<float>(v - y);
    const std::uint8_t *above = image.row(y) + x, *below = image.row(y + 1) + x;
    const float top = above[0] + a * static_cast<float>(above[1] - above[0]);
    const float bottom = below[0] + a * static_cast<float>(below[1] - below[0]);
    return top + b * (bottom - top);
}

/// Value of a profile between pixels, 0 outside.
double value(const float *profile, double offset) {
    const double x = offset + reach;
    if (!(x >= 0 && x < 2 * reach))
        return 0;
    const auto i = static_cast<std::ptrdiff_t>(x);
    const double part = x - static_cast<double>(i);
    return (1 - part) * profile[i] + part * profile[i + 1];
}

/// Calls `use(s, mean)` with the mean of `values` around each place s of a profile.
template <class T, class Use>
void around(const std::array<T, length> &values, const Use &use) {
    T sum = 0;
    for (int s = 0; s < surroundings; ++s)
        sum += values[static_cast<std::size_t>(s)];
    for (int s = 0; s < length; ++s) {
        const int first = std::max(s - surroundings, 0);
        const int last = std::min(s + surroundings, length - 1);
        if (s + surroundings < length)
            sum += values[static_cast<std::size_t>(last)];
        if (s > surroundings)
            sum -= values[static_cast<std::size_t>(first - 1)];
        use(s, sum / static_cast<T>(last - first + 1));
    }
}

} // namespace

EdgeView::EdgeView(const Intrinsics &camera, int capacity)
    : camera_(camera), image_(camera.width, camera.height) {
    edges_.reserve(static_cast<std::size_t>(capacity));
}

void EdgeView::take(std::span<const DepthEdge> edges, ImageView<const float> image,
                    const Twist &rate) {
    assert(image.same_size(image_.view()) && edges.size() <= edges_.capacity());
    for (int v = 0; v < image.height(); ++v)
        std::transform(image.row(v), image.row(v) + image.width(), image_.row(v),
                       [](float grey) { return static_cast<std::uint8_t>(grey + 0.5f); });
    rate_ = rate;
    edges_.clear();
    for (const DepthEdge &edge : edges) {
        const Eigen::Vector3d X = edge.at.cast<double>(), beyond = edge.beyond.cast<double>();
        if (!(X.z() > nearest_m && beyond.z() > nearest_m))
            continue;
        const Eigen::Vector2d place = camera_.project(X);
        const Eigen::Vector2d n = (camera_.project(beyond) - place).normalized();
        const Eigen::Vector3d by_X{
            n.x() * camera_.fx / X.z(), n.y() * camera_.fy / X.z(),
            -(n.x() * (place.x() - camera_.cx) + n.y() * (place.y() - camera_.cy)) / X.z()};
        Edge &seen = edges_.emplace_back();
        seen.at = X;
        seen.across = n;
        seen.by_error << X.cross(by_X), by_X, -by_X.z() * X.z(),
            -by_X.dot(rate.head<3>() + rate.tail<3>().cross(X)), 1;
    }
}

void EdgeView::look(const RigError &error, EdgeProfiles &profiles) const {
    for (int i = 0; i < size(); ++i)
        look_across(edges_[static_cast<std::size_t>(i)], error, profiles.of(i));
    // What all edges have in common at some distance, as patterns on the near surfaces, says
    // nothing.
    std::array<double, length> common{};
    for (int i = 0; i < size(); ++i)
        for (std::size_t s = 0; s < common.size(); ++s)
            common[s] += profiles.of(i)[s];
    around(common, [&](int s, double sum) {
        const float mean = static_cast<float>(sum / size());
        for (int i = 0; i < size(); ++i)
            profiles.of(i)[s] -= mean;
    });
}

/// Writes by which share the image's gradient surpasses that of its surroundings.
void EdgeView::look_across(const Edge &edge, const RigError &error, float *profile) const {
    using namespace rig_error;
    const Eigen::Vector3d X =
        edge.at + error.segment<3>(displacement) + error.segment<3>(turn).cross(edge.at);
    std::fill(profile, profile + length, 0.0f);
    if (!(X.z() > nearest_m))
        return;
    const Eigen::Vector2d centre{camera_.cx, camera_.cy};
    const Eigen::Vector2d place = centre + (1 + error[focal]) * (camera_.project(X) - centre) +
                                  (edge.by_error[lag] * error[lag] + error[margin]) * edge.across;
    std::array<float, length + 2> grey{};
    for (std::size_t s = 0; s < grey.size(); ++s) {
        const Eigen::Vector2d at = place + (static_cast<double>(s) - reach - 1) * edge.across;
        grey[s] = sample(image_, at.x(), at.y());
    }
    std::array<float, length> gradient{};
    for (std::size_t s = 0; s < gradient.size(); ++s)
        gradient[s] = grey[s] < 0 || grey[s + 1] < 0 || grey[s + 2] < 0
                          ? 0.0f
                          : 0.5f * std::abs(grey[s + 2] - grey[s]);
    around(gradient, [&](int s, float mean) {
        profile[s] =
            std::clamp(gradient[static_cast<std::size_t>(s)] / (mean + noise) - 1, 0.0f, strongest);
    });
}

double EdgeView::score(const EdgeProfiles &profiles, const RigError &step, int every) const {
    double sum = 0;
    int count = 0;
    for (int i = 0; i < size(); i += every, ++count) {
        const double offset = edges_[static_cast<std::size_t>(i)].by_error.dot(step);
        const float *profile = profiles.of(i);
        sum += value(profile, offset) +
               0.5 * (value(profile, offset - 1) + value(profile, offset + 1));
    }
    return sum / std::max(count, 1);
}

void EdgeView::gather(const EdgeProfiles &profiles, double spread, EdgeEvidence &evidence) const {
    std::array<double, length> kernel{};
    for (int s = 0; s < length; ++s) {
        const double sigmas = (s - reach) / spread;
        kernel[static_cast<std::size_t>(s)] =
            std::abs(sigmas) <= 2.5 ? std::exp(-0.5 * sigmas * sigmas) : 0.0;
    }
    for (int i = 0; i < size(); ++i) {
        const float *profile = profiles.of(i);
        double sum = 0, moment = 0;
        for (int s = 0; s < length; ++s) {
            const double w = kernel[static_cast<std::size_t>(s)] * std::max(profile[s], 0.0f);
            sum += w;
            moment += w * (s - reach);
        }
        if (sum < 0.1)
            continue;
        const double offset = moment / sum, trust = sum / (sum + 1);
        const RigError &J = edges_[static_cast<std::size_t>(i)].by_error;
        evidence.H.noalias() += trust * J * J.transpose();
        evidence.g += trust * offset * J;
        evidence.weight += trust;
        evidence.squares += trust * offset * offset;
    }
}

void EdgeView::add_sensitivity(Eigen::Matrix<double, 9, 9> &squares) const {
    for (const Edge &edge : edges_)
        squares.noalias() += edge.by_error * edge.by_error.transpose();
}

} // namespace afterglow
