// SPDX-License-Identifier: Apache-2.0
#include "tools/characterise/settling.hpp"

#include "core/base/median.hpp"

#include <cassert>
#include <cmath>

namespace afterglow {
namespace {

constexpr int step = 2; ///< every so many rows and columns are compared
// Of what settled maps show.
constexpr float least_share = 0.95F;
constexpr float most_difference = 1.5F;
constexpr float most_bias = 0.003F;

} // namespace

Settling::Settling(ImageView<const float> reference) : reference_(reference) {}

void Settling::learn(DepthView map) {
    const Agreement agreement = compare(map);
    usual_share_ += agreement.share;
    usual_difference_ += agreement.difference;
    ++learnt_;
}

bool Settling::is_settled(DepthView map) {
    assert(learnt_ > 0);
    const auto learnt = static_cast<float>(learnt_);
    const Agreement agreement = compare(map);
    return agreement.share >= least_share * usual_share_ / learnt &&
           std::abs(agreement.bias) <= most_bias &&
           agreement.difference <= most_difference * usual_difference_ / learnt + 0.001F;
}

Settling::Agreement Settling::compare(DepthView map) {
    differences_.clear();
    int known = 0;
    for (int v = 0; v < map.height(); v += step)
        for (int u = 0; u < map.width(); u += step) {
            const float z = reference_(u, v);
            known += z > 0;
            if (z > 0 && map(u, v) != 0)
                differences_.push_back(0.001F * static_cast<float>(map(u, v)) / z - 1);
        }
    if (differences_.empty())
        return {};
    Agreement agreement;
    agreement.share = static_cast<float>(differences_.size()) / static_cast<float>(known);
    agreement.bias = median(differences_);
    for (float &difference : differences_)
        difference = std::abs(difference);
    agreement.difference = median(differences_);
    return agreement;
}

} // namespace afterglow
