// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "core/alignment/direct_alignment.hpp"
#include "core/base/image.hpp"
#include "core/base/views.hpp"
#include "core/base/worker_pool.hpp"
#include "core/base/worker_shares.hpp"
#include "core/moving/image_patch.hpp"

#include <cstdint>

namespace afterglow {

/// Where the scene moves against itself.
///
/// Under the pose that most of a template's points agree on, points of something that moved by
/// itself, and of what it now hides, meet other grey values than their own. The published
/// picture is parted into square cells; a cell moves when most of the points that fall into it
/// deviate by more than 2.5 times what the others do. Points that a nearer surface of the composed
/// map hides tell nothing, and neither does a cell with few points. Templates leave depth edges
/// out. A cell moves, too, when its mean grey value is not the one expected by the keyframe's
/// image: that shows things without texture, and blur hardly changes a mean.
///
/// Allocates when made; the calls are real-time safe.
class MotionMask {
public:
    static constexpr int cell_px = 32;
    /// Cells along so many pixels; the last may reach beyond them.
    static constexpr int cells(int pixels) { return (pixels + cell_px - 1) / cell_px; }

    /// `image_level`: the pyramid level of keyframes' images.
    MotionMask(const Views &views, int image_level, WorkerPool &pool);

    /// `alignment`: of `image` with `reference`, good. `composed`: the depth map made for the
    /// image, millimetres, of the published camera.
    void find(const AlignmentTemplate &reference, const Pyramid &image, const Alignment &alignment,
              DepthView composed);
    /// Adds each cell whose middle has about one depth, and a mean grey value that is not the one
    /// expected by the keyframe's image. `then`: that image, on `image_level`. `at`: pose, gain and
    /// offset of the keyframe in the new image, `now`. `composed`: as for find().
    void add_unlike(const KeyframeImage &then, const Pyramid &now, const Placement &at,
                    DepthView composed);

    /// One for each cell, 1 where it moves.
    ImageView<const std::uint8_t> moving() const { return moving_; }

private:
    struct Count {
        int points = 0;
        int outliers = 0;

        Count operator+(const Count &other) const {
            return {points + other.points, outliers + other.outliers};
        }
    };

    using Counts = Image<Count>; ///< of each cell

    /// Counts the points first..end-1.
    void count(const AlignmentTemplate &reference, const Pyramid &image, const Alignment &alignment,
               DepthView composed, int first, int end, Counts &counts) const;
    /// Where the published camera sees a point at pixel (u, v) of the tracking camera.
    Eigen::Vector2i published_pixel(int u, int v, float depth) const;

    Views views_;
    bool same_;               ///< both cameras are one
    int image_level_;         ///< pyramid level of keyframes' images
    Intrinsics image_camera_; ///< the tracking camera on that level
    WorkerPool &pool_;
    WorkerShares<Counts> counts_;
    Image<std::uint8_t> moving_;
};

} // namespace afterglow
