// SPDX-License-Identifier: Apache-2.0
#include "tools/calibrate/still_views.hpp"

#include <algorithm>
#include <limits>

namespace afterglow {
namespace {

constexpr std::int64_t rest_ns = 600'000'000;
constexpr double at_rest = 0.0025; ///< of the image's width: how far corners may move
constexpr double new_place = 0.04; ///< how far from all other views they must be

/// Mean distance between the same corners; infinite where they have none in common.
double distance(const Corners &a, const Corners &b) {
    double sum = 0;
    int count = 0;
    for (std::size_t i = 0; i < a.size(); ++i) {
        const auto same = std::find(b.numbers.begin(), b.numbers.end(), a.numbers[i]);
        if (same == b.numbers.end())
            continue;
        sum += (b.pixels[static_cast<std::size_t>(same - b.numbers.begin())] - a.pixels[i]).norm();
        ++count;
    }
    return count > 0 ? sum / count : std::numeric_limits<double>::infinity();
}

} // namespace

StillViews::Advice StillViews::look(const Corners &corners, std::int64_t t_ns) {
    if (corners.empty()) {
        reference_ = {};
        return Advice::no_board;
    }
    if (distance(corners, reference_) > at_rest * width_) {
        reference_ = corners;
        since_ns_ = t_ns;
        return Advice::moving;
    }
    if (t_ns - since_ns_ < rest_ns)
        return Advice::moving;
    const bool known = std::any_of(taken_.begin(), taken_.end(), [&](const Corners &other) {
        return distance(corners, other) < new_place * width_;
    });
    return known ? Advice::known : Advice::take_it;
}

void StillViews::take(const Corners &corners) {
    taken_.push_back(corners);
    coverage_.add(corners);
}

} // namespace afterglow
