// SPDX-License-Identifier: Apache-2.0
#include "tools/characterise/edges.hpp"

#include <algorithm>
#include <cmath>

namespace afterglow {
namespace {

constexpr int between = 4; ///< pixels of a crossing
constexpr int beside = 2;  ///< of the surface on each side of it that must be flat
/// Of the depth, and of the noise; an edge is a larger step.
constexpr float least_step = 0.15F, least_sigmas = 12;
constexpr float flat = 0.02F;

} // namespace

Edges::Edges(ImageView<const float> reference, const SensorNoise &noise) : noise_(noise) {
    find(reference, 1, 0);
    find(reference, 0, 1);
}

void Edges::find(ImageView<const float> reference, int du, int dv) {
    constexpr int last = between + 2 * beside - 1;
    for (int v = 0; v + dv * last < reference.height(); ++v)
        for (int u = 0; u + du * last < reference.width(); ++u) {
            const auto z = [&](int i) { return reference(u + du * i, v + dv * i); };
            const float left = z(beside - 1), right = z(beside + between);
            const float near = std::min(left, right);
            if (near == 0 || std::abs(left - right) <
                                 std::max(least_step * near, least_sigmas * noise_.sigma(near)))
                continue;
            // A slanted surface between both, such as a box's side, is no edge: two pixels at most
            // may be on neither. A zero is a hole of the reference.
            const auto is_left = [&](int i) { return std::abs(z(i) - left) <= flat * left; };
            const auto is_right = [&](int i) { return std::abs(z(i) - right) <= flat * right; };
            const float half = 0.5F * (left + right);
            const float before = z(last / 2), after = z(last / 2 + 1);
            if (is_left(0) && is_left(beside) && is_right(last - beside) && is_right(last) &&
                before > 0 && after > 0 && (before < half) == (left < half) &&
                (after < half) == (right < half))
                crossings_.push_back({u + du * beside, v + dv * beside, du, dv, left, right});
        }
}

void Edges::add(DepthView map) {
    for (const Crossing &crossing : crossings_) {
        const float near = std::min(crossing.left, crossing.right);
        const float far = std::max(crossing.left, crossing.right);
        const float margin = 0.1F * (far - near);
        float place = 0;
        int readings = 0;
        for (int i = 0; i < between; ++i) {
            const float z = 0.001F * static_cast<float>(map(crossing.u + i * crossing.du,
                                                            crossing.v + i * crossing.dv));
            if (z == 0)
                continue;
            ++readings;
            flying_ += z > near + std::max(margin, 3 * noise_.sigma(near)) &&
                       z < far - std::max(margin, 3 * noise_.sigma(far));
            place +=
                std::clamp((z - crossing.right) / (crossing.left - crossing.right), 0.0F, 1.0F);
        }
        ++seen_;
        if (readings == between) {
            ++placed_;
            squares_ += std::pow(place - 0.5F * between, 2);
        }
    }
}

EdgeBehaviour Edges::behaviour() const {
    return {static_cast<int>(crossings_.size()),
            seen_ > 0 ? static_cast<float>(flying_) / static_cast<float>(seen_) : 0,
            placed_ > 0 ? static_cast<float>(std::sqrt(squares_ / static_cast<double>(placed_)))
                        : 0};
}

} // namespace afterglow
