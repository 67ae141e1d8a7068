// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "core/base/image.hpp"
#include "core/estimate.hpp"

#include <vector>

namespace afterglow {

/// How much of two depth maps is the same.
struct Agreement {
    double share_of_first = 0;  ///< of the first one's readings, those that the second has as well
    double share_of_second = 0; ///< the other way round
    double difference = 0;      ///< median of |a - b| / b where both have one
};

/// Tells the maps of a TOF camera that has not settled, by what they measure.
///
/// A light that has just gone on gives maps with holes, or with biased depth, which change from
/// one to the next. A map has settled that agrees with what is expected of it, or with the map
/// before it. Estimator thread; allocates nothing after it was made.
class WarmupFilter {
public:
    /// `most`: maps after light on that are passed over at most; 0 = none.
    WarmupFilter(int most, int width, int height);

    /// The light has gone on.
    void relit();
    /// Whether the map, the next since light on, is a measurement. `expected`: for the same image.
    bool is_settled(DepthView map, const Estimate &expected);

private:
    Agreement compare(DepthView a, DepthView b);

    const int most_;
    int passed_ = 0;
    bool settled_ = false;
    DepthMap previous_;
    std::vector<float> differences_; ///< of compare()
};

} // namespace afterglow
