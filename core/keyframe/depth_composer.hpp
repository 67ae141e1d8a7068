// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "core/alignment/direct_alignment.hpp"
#include "core/base/image.hpp"
#include "core/base/worker_pool.hpp"
#include "core/error/confidence_kernels.hpp"
#include "core/error/expected_error.hpp"
#include "core/error/local_errors.hpp"
#include "core/error/map_comparison.hpp"
#include "core/estimate.hpp"
#include "core/keyframe/keyframe.hpp"
#include "core/keyframe/keyframe_options.hpp"
#include "core/moving/motion_mask.hpp"
#include "core/moving/residual_flow.hpp"
#include "core/warp/warp.hpp"

#include <array>
#include <cstdint>
#include <span>

namespace afterglow {

/// Draws one depth map from several keyframes: the reference map first, then those that see most
/// of the view, each into the pixels that are still empty. Pixels get the confidence that their
/// expected error deserves.
///
/// Allocates when made; the calls are real-time safe.
class DepthComposer {
public:
    DepthComposer(const Views &views, const KeyframeOptions &options, WorkerPool &pool);

    /// `now`: world to published camera, when its depth map would be exposed. `alignment`: of the
    /// image with keyframe `reference`. `rate`: CameraMotion::rate(). Stops when `enough` pixels
    /// are covered. The map shows what a TOF camera with that `correction` would read. The last map
    /// stays if it would hardly differ.
    void compose(const KeyframeSet &keyframes, int reference, const Pose &now,
                 const Alignment &alignment, const Twist &rate, int enough,
                 const DepthCorrection &correction = {});
    /// What makes the pixels of the composed map wrong, beside its MapError.
    struct Doubts {
        /// Factors on the modelled errors.
        ErrorScales scales{};
        /// Errors to be added to those of a cell's pixels. Null: none.
        const LocalErrors *local = nullptr;
    };
    /// Gives the pixels of the composed map the confidence that their expected error deserves.
    /// Where the map has stayed, only cells of which a doubt has changed are judged anew. Not
    /// `all_rows`: only those that expected_mre() is worked out from.
    void judge(const Doubts &doubts, bool all_rows = true);
    /// Judges the rows that judge() has left out.
    void judge_rest();
    /// The map beside one that was measured for the same image, by cell of MotionMask, at every
    /// second pixel of every second row that has depth in both. Valid until the next call. All
    /// pixels must have been judged.
    ImageView<const ComparedErrors> compare(DepthView measured);
    /// Shows what moves by itself where the last image shows it, and leaves empty what the keyframe
    /// does not show: `flow` was found for that image and drawn().
    void displace(const ResidualFlow &flow);
    /// The composed map before displace(), until a measured map is laid over it.
    DepthView drawn();
    /// Empties the map.
    void clear();
    /// Lays a measured map over the composed one; pixels it lacks stay as they were composed.
    /// Returns how many it has. All pixels must have been judged.
    int overlay(DepthView measured);

    DepthMap &depth() { return depth_; }
    /// Holds for pixels that have been judged.
    Image<std::uint8_t> &confidence() { return confidence_; }
    /// Pixels that have depth.
    int covered() const { return covered_; }
    /// Pixels that have none because the keyframe does not show what is there.
    int left_empty() const { return left_empty_; }
    /// Mean of what the confidences promise, percent, over the pixels that have depth in every
    /// eighth row, or after overlay() in all; 100 without.
    float expected_mre() const;
    /// The same with an uncorrelated_share() of 1.
    float independent_mre() const;
    /// uncorrelated_share() of the reference and a map measured now; 1 without a composed map.
    float uncorrelated() const { return layer_count_ > 0 ? layers_[0].uncorrelated : 1; }
    /// The last compose() has drawn a new map.
    bool drawn_anew() const { return drawn_anew_; }

private:
    /// Most maps in one.
    static constexpr int most_layers = 16;
    /// Confidence by class and by bin of depth, as place_in_table(); none where there is no depth.
    using ConfidenceTable = std::array<std::uint8_t, most_layers * class_layer * depth_bins>;
    /// Of when, from where and how the first map of the composed one was drawn.
    struct Drawn {
        std::int64_t t_ns = 0; ///< Keyframe's
        Pose pose;             ///< from its depth camera to the published one
        RollingShutter shutter;
    };
    /// What the confidences of a map's pixels follow from.
    struct Layer {
        MapError error;
        SensorNoise noise;
        float uncorrelated = 1; ///< uncorrelated_share() of it and a map measured now
    };

    /// What lowers the confidences of a cell's pixels, and what came of it.
    struct Cell {
        float local = 0;           ///< relative error that is added
        std::uint8_t less = 0;     ///< steps by which that lowers confidences
        ConfidenceSum judged;      ///< over one row in `summed_row`
        ConfidenceSum independent; ///< the same, for independent_mre()
        bool judge = false;        ///< whether this has to be worked out
        bool unfinished = false;   ///< other rows have not been judged
        bool kept = false;         ///< drawn_depth_ and so on have it
        bool displaced = false;    ///< some of its pixels are
        bool changed = false;      ///< its depths, though the map was not drawn anew
    };

    RollingShutter shutter(const Alignment &alignment, const Twist &while_read) const;
    bool looks_as_drawn(const Keyframe &keyframe, const Drawn &next) const;
    std::span<const int> pick_keyframes(const KeyframeSet &keyframes, int reference,
                                        const Pose &now, std::span<int, most_layers> picked) const;
    void find_places();
    void fill_in();
    void displace_run(int left, int right, int top, int bottom, const ResidualFlow::Shift &shift);
    void keep(int left, int right, int top, int bottom);
    void restore();
    void make_tables(const ErrorScales &scales);
    bool find_doubts(const Doubts &doubts, bool all_rows);
    void judge_cell(int x, int y, bool all_rows);

    Views views_;
    Intrinsics camera_; ///< the published one
    KeyframeOptions options_;
    WorkerPool &pool_;
    Warp warp_;
    DepthMap depth_;
    Image<std::uint8_t> classes_;
    /// JudgedPixels::places of the map as it was drawn.
    Image<std::uint16_t> places_;
    Image<std::uint8_t> confidence_;
    DepthMap drawn_depth_; ///< the map as it was drawn, and so on: of cells that are kept
    Image<std::uint8_t> drawn_classes_;
    int drawn_covered_ = 0;
    DepthMap further_; ///< a further map, and its edge distances
    Image<std::uint8_t> further_edges_;
    Image<ComparedErrors> compared_;
    Image<Cell> cells_;
    Drawn drawn_;
    std::array<Layer, most_layers> layers_;
    int layer_count_ = 0; ///< of the composed map; 0: compose() has not drawn the map
    int covered_ = 0;
    int left_empty_ = 0;
    ConfidenceSum judged_, independent_; ///< Cell's, of all of them
    ErrorScales scales_;                 ///< of the last doubts
    ConfidenceTable table_{}, independent_table_{};
    float misplaced_ = 0; ///< MapError's, the most of the maps drawn
    bool drawn_anew_ = false;
    bool displaced_ = false; ///< some of the map's pixels are
    bool all_kept_ = false;  ///< all cells
};

} // namespace afterglow
