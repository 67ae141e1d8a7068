// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "core/base/image.hpp"

#include <vector>

namespace afterglow {

/// Whether a map shows the reference as settled maps do.
class Settling {
public:
    /// `reference`: metres, 0 = none.
    explicit Settling(ImageView<const float> reference);

    /// A settled map: how much such maps differ.
    void learn(DepthView map);
    bool is_settled(DepthView map);

private:
    struct Agreement {
        float share = 0;      ///< of the reference's readings that the map has as well
        float bias = 0;       ///< median of the relative difference
        float difference = 0; ///< median of its amount
    };
    Agreement compare(DepthView map);

    ImageView<const float> reference_;
    std::vector<float> differences_;
    int learnt_ = 0;
    float usual_share_ = 0, usual_difference_ = 0; ///< sums over what was learnt
};

} // namespace afterglow
