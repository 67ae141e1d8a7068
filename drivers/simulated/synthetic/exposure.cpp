// SPDX-License-Identifier: Apache-2.0
#include "drivers/simulated/synthetic/exposure.hpp"

#include "drivers/simulated/synthetic/random.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <numbers>

namespace afterglow {

double Exposure::factor(double t_s) const {
    constexpr double jump_s = 2, drift_s = 7;
    const double step = std::floor(t_s / jump_s);
    Random random(seed_ + static_cast<std::uint64_t>(static_cast<std::int64_t>(step)), 4);
    const double level = random.uniform(-0.5, 0.5);
    const double drift = 0.5 * std::sin(2 * std::numbers::pi * t_s / drift_s);
    return std::exp2(stops_ * (level + drift));
}

void Exposure::apply(double t_s, ImageView<std::uint8_t> luma) const {
    if (stops_ == 0)
        return;
    std::array<std::uint8_t, 256> table{};
    const double by = factor(t_s);
    for (std::size_t i = 0; i < table.size(); ++i)
        table[i] = static_cast<std::uint8_t>(std::min(by * static_cast<double>(i) + 0.5, 255.0));
    for (int v = 0; v < luma.height(); ++v) {
        for (int u = 0; u < luma.width(); ++u)
            luma.row(v)[u] = table[luma.row(v)[u]];
    }
}

} // namespace afterglow
