// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "core/alignment/direct_alignment.hpp"
#include "core/base/image.hpp"
#include "core/base/views.hpp"

#include <cstdint>

namespace afterglow {

/// Where the scene moves against itself.
///
/// Under the pose that most of a template's points agree on, points of something that moved by
/// itself, and of what it now hides, meet other grey values than their own. The published
/// picture is parted into square cells; a cell moves when most of the points that fall into it
/// deviate by more than 2.5 times what the others do. Points that a nearer surface of the composed
/// map hides tell nothing, and neither does a cell with few points. Templates leave depth edges
/// out.
///
/// Allocates when made; find() is real-time safe.
class MotionMask {
public:
    static constexpr int cell_px = 32;
    /// Cells along so many pixels; the last may reach beyond them.
    static constexpr int cells(int pixels) { return (pixels + cell_px - 1) / cell_px; }

    explicit MotionMask(const Views &views);

    /// `alignment`: of `image` with `reference`, good. `composed`: the depth map made for the
    /// image, millimetres, of the published camera.
    void find(const AlignmentTemplate &reference, const Pyramid &image, const Alignment &alignment,
              DepthView composed);

    /// One for each cell, 1 where it moves.
    ImageView<const std::uint8_t> moving() const { return moving_; }

private:
    struct Count {
        int points = 0;
        int outliers = 0;
    };

    /// Where the published camera sees a point at pixel (u, v) of the tracking camera.
    Eigen::Vector2i published_pixel(float u, float v, float depth) const;

    Views views_;
    bool same_; ///< both cameras are one
    Image<Count> counts_;
    Image<std::uint8_t> moving_;
};

} // namespace afterglow
