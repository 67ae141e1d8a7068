// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "core/base/image.hpp"
#include "core/base/pyramid.hpp"
#include "core/keyframe/image_patch.hpp"
#include "core/keyframe/residuals.hpp"
#include "core/keyframe/views.hpp"

#include <Eigen/Core>

#include <array>
#include <cstdint>

namespace afterglow {

/// Motion in the image that is not the camera's: optical flow between the image that the camera's
/// motion makes of a keyframe's and the image that was taken.
///
/// It is looked for where the scene moves against itself (MotionMask), as dense inverse search does
/// (Kroeger et al. 2016, arXiv 1603.03590): overlapping square patches of the image, on one level
/// of its pyramid, are found in the keyframe's by Gauss-Newton steps from what their neighbours and
/// the last image tell, and each pixel is displaced like that patch around it which explains it
/// best. A displacement that leaves much of a patch's difference is none.
///
/// Finds nothing where the published view is not the tracking camera's. Allocates when made; the
/// calls are real-time safe.
class ResidualFlow {
public:
    /// `most_level`: of the pyramid; `search`: flow is looked for.
    ResidualFlow(const Views &views, int most_level, bool search = true);

    /// The pyramid level whose pixels are displaced.
    static int level_for(const Intrinsics &tracking, int most_level);
    int level() const { return level_; }

    /// A keyframe's image on that level, and when it was taken.
    struct Then {
        ImageView<const float> image;
        std::int64_t t_ns = 0;
    };
    /// `at`: how the new image, `now`, shows the keyframe. `composed`: the depth map drawn for it,
    /// millimetres. `moving`: cells of MotionMask, 1 where the scene moves.
    void find(const Then &then, const Pyramid &now, const Placement &at, DepthView composed,
              ImageView<const std::uint8_t> moving);

    /// From where in the composed map a pixel gets its depth: so many pixels of the map farther
    /// right and down.
    struct Shift {
        std::int16_t u = 0, v = 0;
        bool operator==(const Shift &) const = default;
    };
    /// Some pixel is displaced.
    bool any() const { return any_; }
    /// Some pixel is displaced otherwise than in the image before.
    bool changed() const { return changed_; }
    /// One for each pixel of the level.
    ImageView<const Shift> shifts() const { return shifts_; }
    /// By cell: 1 where the scene moves and displacements do not explain what is seen.
    ImageView<const std::uint8_t> unexplained() const { return unexplained_; }

private:
    struct Patch {
        bool looked_for = false; ///< in the last image
        bool moves = false;
        bool unlike = false; ///< neither where the camera's motion puts it, nor displaced
        /// Where the camera's motion puts its first pixel in the keyframe's image, and how far from
        /// there it is found, pixels of the level.
        Eigen::Vector2f place = {0, 0}, from = {0, 0};
        Shift shift;
        float still = 0; ///< mean square difference where the camera's motion puts it
        PatchFit fit;    ///< at from
        /// What the last spread() took.
        Shift spread;
        Eigen::Vector2f spread_place = {0, 0};

        Shift displacement() const { return moves ? shift : Shift{}; }
    };
    /// What find() got.
    struct Search {
        Then then;
        ImageView<const float> now; ///< of the level
        const Placement &at;
        Pose to_then; ///< points of the new image's frame to the keyframe's
        DepthView composed;
    };
    /// Pixels of the level.
    struct Area {
        int left = 0, top = 0, right = 0, bottom = 0;
    };

    void choose_patches(ImageView<const std::uint8_t> moving);
    void look_for(int x, int y, const Search &in);
    void look_again(int x, int y, const Search &in);
    static bool differs(const Patch &patch, const Patch &neighbour);
    std::array<const Patch *, 4> neighbours(int x, int y) const;
    static bool try_from(const Eigen::Vector2f &from, const ImagePatch &seen, const Search &in,
                         Patch &patch);
    void go_on(int x, int y, const ImagePatch &seen, const Search &in);
    Eigen::Vector2f place_of(const Eigen::Vector2f &first, const Search &in) const;
    Shift shift_of(const Patch &patch, int x, int y, const Search &in) const;
    static bool needs_spreading(const Patch &patch);
    void spread(const Search &in);
    Area area_of_patches() const;
    static Area joined(const Area &a, const Area &b);
    void find_unexplained(ImageView<const std::uint8_t> moving);

    bool search_;
    int level_;
    Intrinsics camera_; ///< of the level
    Image<Patch> patches_;
    Image<float> least_;        ///< difference of each pixel of the level, grey values
    Image<std::int32_t> owner_; ///< the patch that it is displaced like, -1 = none
    Image<Shift> shifts_;
    Area area_; ///< of what was displaced in the last image
    Image<std::uint8_t> unexplained_;
    std::int64_t then_ns_ = 0; ///< of the keyframe that patches are found in
    bool any_ = false, changed_ = false;
};

} // namespace afterglow
