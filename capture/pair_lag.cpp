// SPDX-License-Identifier: Apache-2.0
#include "capture/pair_lag.hpp"

#include <cmath>

namespace afterglow {
namespace {

/// Half of the time between two maps at 30 FPS.
constexpr double most_jitter_s = 1.0 / 60;
/// Weight of a new pair in the usual difference, which changes as the cameras' clocks drift apart.
constexpr double new_share = 0.1;

double difference_s(std::int64_t image_ns, std::int64_t map_ns) {
    return 1e-9 * static_cast<double>(map_ns - image_ns);
}

} // namespace

double PairLag::of(std::int64_t image_ns, std::int64_t map_ns) const {
    const double difference = difference_s(image_ns, map_ns);
    if (!registered_)
        return difference;
    const double unusual = difference - usual_s_.value_or(difference);
    return std::abs(unusual) > most_jitter_s ? unusual : 0;
}

void PairLag::add_pair(std::int64_t image_ns, std::int64_t map_ns) {
    const double difference = difference_s(image_ns, map_ns);
    if (!usual_s_)
        usual_s_ = difference;
    else if (of(image_ns, map_ns) == 0)
        *usual_s_ += new_share * (difference - *usual_s_);
}

} // namespace afterglow
