// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "core/base/image.hpp"
#include "core/base/worker_pool.hpp"
#include "core/estimate.hpp"
#include "core/keyframe/direct_alignment.hpp"
#include "core/keyframe/expected_error.hpp"
#include "core/keyframe/keyframe.hpp"
#include "core/keyframe/keyframe_options.hpp"
#include "core/keyframe/local_errors.hpp"
#include "core/keyframe/motion_mask.hpp"
#include "core/keyframe/warp.hpp"
#include "core/keyframe/warp_kernels.hpp"

#include <array>
#include <cstdint>

namespace afterglow {

/// Draws one depth map from several keyframes: the reference map first, then those that see most
/// of the view, each into the pixels that are still empty. Every pixel gets the confidence that its
/// expected error deserves.
///
/// Allocates when made; the calls are real-time safe.
class DepthComposer {
public:
    DepthComposer(const Views &views, const KeyframeOptions &options, WorkerPool &pool);

    /// `now`: world to published camera, when its depth map would be exposed. `alignment`: of the
    /// image with keyframe `reference`. `while_read`: motion of the scene before the tracking
    /// camera while Views::readout_s. Stops when `enough` pixels are covered. The map shows what a
    /// TOF camera with that `correction` would read. `error_scale`: factor on the modelled errors.
    void compose(const KeyframeSet &keyframes, int reference, const Pose &now,
                 const Alignment &alignment, const Twist &while_read, int enough,
                 const DepthCorrection &correction = {}, float error_scale = 1);
    /// Lowers the confidence of what lies in moving cells to that of `relative_error`.
    void distrust(const MotionMask &mask, float relative_error);
    /// Adds what is expected of each cell to that of its pixels, in quadrature. `scale`: factor on
    /// it.
    void distrust(const LocalErrors &errors, float scale);
    /// The map beside one that was measured for the same image, by cell of MotionMask, at every
    /// second pixel of every second row that has depth in both. Valid until the next call.
    ImageView<const ComparedErrors> compare(DepthView measured);
    /// Empties the map.
    void clear();
    /// Lays a measured map over the composed one; pixels it lacks stay as they were composed.
    void overlay(DepthView measured);

    DepthMap &depth() { return depth_; }
    Image<std::uint8_t> &confidence() { return confidence_; }
    /// Pixels that have depth.
    int covered() const { return covered_; }
    /// Mean of what the confidences promise over the pixels that have depth, percent; 100 without.
    float expected_mre() const;

private:
    /// Confidence by class (find_readings()): by distance from the next depth edge and by depth.
    using ConfidenceTable =
        std::array<std::uint8_t, static_cast<std::size_t>(warped_edge_mask + 1) * reading_bins>;

    void merge(const MapError &error, const DepthSurface &surface, float error_scale);
    int merge_row(int v, int begin, int end, const ConfidenceTable &table);
    template <class Visit>
    void for_each_cell(const Visit &visit);

    Views views_;
    Intrinsics camera_; ///< the published one
    KeyframeOptions options_;
    WorkerPool &pool_;
    Warp warp_;
    DepthCorrection correction_;
    DepthMap depth_;
    Image<std::uint8_t> confidence_;
    Image<ComparedErrors> compared_;
    int covered_ = 0;
    float misplaced_ = 0; ///< MapError's, the most of the maps drawn
};

} // namespace afterglow
