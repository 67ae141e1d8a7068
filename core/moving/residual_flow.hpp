// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "core/alignment/residuals.hpp"
#include "core/base/image.hpp"
#include "core/base/pyramid.hpp"
#include "core/base/views.hpp"
#include "core/moving/image_patch.hpp"

#include <Eigen/Core>

#include <array>
#include <cstdint>

namespace afterglow {

/// Residual flow: the optical flow that is left between a keyframe's image and a new one after the
/// camera's motion is taken off. It tells where things are that move by themselves.
///
/// It is searched for in and around the cells in which MotionMask saw motion, by dense inverse
/// search (Kroeger et al. 2016, arXiv 1603.03590) on one level of the image pyramid: overlapping
/// square patches of the new image are found in the keyframe's image by Gauss-Newton steps, which
/// start at the flow of the last image and of neighbouring patches. A patch moves if its flow takes
/// away most of its difference. Each pixel gets the shift of the patch around it that differs
/// least; where that one differs, too, the keyframe does not show what is there, and neither does
/// its map.
///
/// No flow is searched for where the published camera is not the tracking camera: all of a moving
/// cell is then taken for what the keyframe does not show. Allocates when made; the calls are
/// real-time safe.
class ResidualFlow {
public:
    /// `most_level`: the coarsest level of the pyramid. Not `enabled`: no flow is searched for.
    ResidualFlow(const Views &views, int most_level, bool enabled = true);

    /// The pyramid level on which flow is found: the finest with at most 200 columns, but none on
    /// which a cell of MotionMask is less than a pixel.
    static int level_for(const Intrinsics &tracking, int most_level);
    int level() const { return level_; }

    /// Finds the flow of a new image, `now`. `then`: on level(). `at`: pose, gain and offset of the
    /// keyframe in it. `composed`: the depth map drawn for it, millimetres. `moving`:
    /// MotionMask::moving().
    void find(const KeyframeImage &then, const Pyramid &now, const Placement &at,
              DepthView composed, ImageView<const std::uint8_t> moving);

    /// From where in the composed map a pixel gets its depth: so many pixels of the map farther
    /// right and down. From nowhere(): it gets none.
    struct Shift {
        std::int16_t u = 0, v = 0;
        bool operator==(const Shift &) const = default;

        static Shift nowhere() { return {INT16_MIN, INT16_MIN}; }
    };
    /// Some pixel has a shift.
    bool any() const { return any_; }
    /// Some pixel has another shift than in the image before.
    bool changed() const { return changed_; }
    /// One for each pixel of the published camera's level().
    ImageView<const Shift> shifts() const { return shifts_; }

private:
    struct Patch {
        bool searched = false; ///< in the last image
        bool moves = false;
        bool unlike = false; ///< differs from the keyframe's image; no flow makes it alike
        /// Where the camera's motion alone puts its first pixel in the keyframe's image, pixels of
        /// the level, and how far from there it was found.
        Eigen::Vector2f place = {0, 0}, flow = {0, 0};
        Shift shift;     ///< if it moves
        float still = 0; ///< mean square difference at `place`, grey values squared
        PatchFit fit;    ///< at place + flow
    };
    /// The arguments of find(), prepared.
    struct Search {
        KeyframeImage then;
        GreyView now; ///< of the level
        Brightness brightness;
        Pose to_then; ///< points of the new image's frame to the keyframe's
        DepthView composed;
    };
    /// Pixels of the level.
    struct Area {
        int left = 0, top = 0, right = 0, bottom = 0;
    };

    bool choose_patches(ImageView<const std::uint8_t> moving);
    void match_patches(const Search &in);
    void match(int x, int y, const Search &in);
    void match_again(int x, int y, const Search &in);
    static bool differs(const Patch &patch, const Patch &neighbour);
    std::array<const Patch *, 4> neighbours(int x, int y) const;
    static bool try_flow(const Eigen::Vector2f &flow, const ImagePatch &seen, const Search &in,
                         Patch &patch);
    void refine(int x, int y, const ImagePatch &seen, const Search &in);
    Eigen::Vector2f place_of(const Eigen::Vector2f &first, const Search &in) const;
    Shift shift_of(const Patch &patch, int x, int y, const Search &in) const;
    void densify(const Search &in);
    Area area_of_patches() const;
    static Area joined(const Area &a, const Area &b);
    void leave_out(ImageView<const std::uint8_t> moving);

    bool enabled_; ///< and the published camera is the tracking camera
    int level_;
    Intrinsics camera_; ///< of the level
    Image<Patch> patches_;
    Image<float> least_;        ///< least difference of a patch at each pixel, grey values
    Image<std::int32_t> owner_; ///< number of the moving patch that a pixel goes with, -1 = none
    Image<Shift> shifts_;
    Area area_;                ///< in which pixels had shifts in the last image
    std::int64_t then_ns_ = 0; ///< of the keyframe that patches are found in
    bool any_ = false, changed_ = false;
};

} // namespace afterglow
