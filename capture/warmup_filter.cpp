// SPDX-License-Identifier: Apache-2.0
#include "capture/warmup_filter.hpp"

#include <algorithm>
#include <cmath>

namespace afterglow {
namespace {

/// Every so many rows and columns are compared.
constexpr int step = 4;

// Maps in a row differ by the camera's motion: at silhouettes, and by a little everywhere.
constexpr double same_share = 0.9;
constexpr double same_depth = 0.02;
// An estimate may be wrong by more, and need not cover all that is measured.
constexpr double expected_share = 0.85;
constexpr double expected_depth = 0.05;

} // namespace

WarmupFilter::WarmupFilter(int most, int width, int height)
    : most_(most), previous_(most > 0 ? DepthMap(width, height) : DepthMap()) {
    if (most > 0)
        differences_.reserve(static_cast<std::size_t>(width / step + 1) *
                             static_cast<std::size_t>(height / step + 1));
}

void WarmupFilter::relit() {
    passed_ = 0;
    settled_ = false;
}

bool WarmupFilter::is_settled(DepthView map, const Estimate &expected) {
    if (settled_ || passed_ >= most_)
        return settled_ = true;
    if (expected.source == FrameSource::estimated) {
        const Agreement agreement = compare(map, expected.depth);
        settled_ =
            agreement.share_of_second >= expected_share && agreement.difference <= expected_depth;
    }
    if (!settled_ && passed_ > 0) {
        const Agreement agreement = compare(map, previous_);
        settled_ = std::min(agreement.share_of_first, agreement.share_of_second) >= same_share &&
                   agreement.difference <= same_depth;
    }
    if (settled_)
        return true;
    copy_pixels(map, previous_.view());
    ++passed_;
    return false;
}

Agreement WarmupFilter::compare(DepthView a, DepthView b) {
    differences_.clear();
    std::size_t in_a = 0;
    std::size_t in_b = 0;
    for (int v = 0; v < a.height(); v += step) {
        for (int u = 0; u < a.width(); u += step) {
            const int of_a = a(u, v);
            const int of_b = b(u, v);
            in_a += of_a != 0;
            in_b += of_b != 0;
            if (of_a != 0 && of_b != 0)
                differences_.push_back(static_cast<float>(std::abs(of_a - of_b)) /
                                       static_cast<float>(of_b));
        }
    }
    if (differences_.empty())
        return {};
    const auto middle = differences_.begin() + static_cast<std::ptrdiff_t>(differences_.size() / 2);
    std::nth_element(differences_.begin(), middle, differences_.end());
    const auto both = static_cast<double>(differences_.size());
    return {both / static_cast<double>(in_a), both / static_cast<double>(in_b), *middle};
}

} // namespace afterglow
