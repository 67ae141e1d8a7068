// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "core/base/image.hpp"
#include "core/surface/sensor_noise.hpp"

#include <cstdint>
#include <vector>

namespace afterglow {

/// How readings behave where a row or a column of a depth map crosses a depth edge.
struct EdgeBehaviour {
    int crossings = 0; ///< of rows and columns; each is seen in many maps
    /// Readings of a crossing that belong to neither surface but lie between them.
    float flying = 0;
    /// By how much the edge is not where the reference has it, pixels (rms over crossings, maps).
    float misplaced_px = 0;
};

/// Looks at the depth edges of a still view, in one map after the other.
///
/// A crossing is four pixels between two surfaces, the edge in their middle. Where each pixel shows
/// the share s of the left surface, s = (z - right) / (left - right) in 0 .. 1, the edge lies at
/// the sum of the four.
class Edges {
public:
    /// `reference`: metres, 0 = none; `noise` tells what is still a surface.
    Edges(ImageView<const float> reference, const SensorNoise &noise);

    void add(DepthView map);
    EdgeBehaviour behaviour() const;

private:
    struct Crossing {
        int u = 0, v = 0;   ///< of its first pixel
        int du = 0, dv = 0; ///< to the next
        float left = 0, right = 0;
    };
    void find(ImageView<const float> reference, int du, int dv);

    SensorNoise noise_;
    std::vector<Crossing> crossings_;
    std::int64_t seen_ = 0, flying_ = 0, placed_ = 0;
    double squares_ = 0;
};

} // namespace afterglow
