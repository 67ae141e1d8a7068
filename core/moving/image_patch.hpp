// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "core/base/grey.hpp"

#include <Eigen/Core>

#include <array>
#include <cstdint>

namespace afterglow {

/// A square part of an image that is looked for in another one. Grey values are compared without
/// their means.
struct ImagePatch {
    static constexpr int side = 8; ///< pixels
    static constexpr std::size_t pixels = std::size_t{side} * side;

    std::array<float, pixels> grey;       ///< as in the image
    std::array<float, pixels> gradient_u; ///< a pixel to the right, without its mean
    std::array<float, pixels> gradient_v; ///< a pixel down, without its mean
    /// Sums of the products of the gradients: u u, u v, v v.
    float uu = 0, uv = 0, vv = 0;

    /// Its gradients have two directions, so that its place is determined.
    bool is_distinct() const {
        constexpr float least_ratio = 1e-3f; // of the eigenvalues, about
        const float trace = uu + vv;
        return uu * vv - uv * uv > least_ratio * trace * trace;
    }
};

/// A keyframe's image on one level of the pyramid.
struct KeyframeImage {
    GreyView grey;
    std::int64_t t_ns = 0; ///< when it was taken
    float contrast = 1;    ///< AlignmentTemplate::contrast()
};

/// The patch whose first pixel is (u, v): 1 <= u < image.width() - side, v alike. Real-time safe.
ImagePatch patch_at(GreyView image, int u, int v);

/// What a grey value of an earlier image has become: `gain` times it, more by `offset`, and white
/// at most. One above nearly_white may have become any brighter value.
struct Brightness {
    float gain = 1, offset = 0;
};

/// How a patch differs from what an image shows at a place.
struct PatchFit {
    float mean_square = 0; ///< of the difference without its mean, grey values squared
    /// The Gauss-Newton step from there towards the patch, pixels right and down. Of patches that
    /// are distinct.
    Eigen::Vector2f step = Eigen::Vector2f::Zero();
};

/// Whether an image shows all of a patch whose first pixel is at `place`.
bool shows_patch(GreyView image, const Eigen::Vector2f &place);

/// Compares a patch with what an earlier image shows at `place` (its first pixel, bilinear), whose
/// grey values have changed by `brightness`. The image shows all of it. Real-time safe.
PatchFit fit_patch(const ImagePatch &patch, GreyView then, const Eigen::Vector2f &place,
                   const Brightness &brightness);

/// How much brighter the square of a patch that begins at pixel (u, v) of `image` is expected to be
/// than it is, by what an earlier image shows at `place`: the mean, grey values. Both images show
/// all of it. Real-time safe.
float mean_excess(GreyView image, int u, int v, GreyView then, const Eigen::Vector2f &place,
                  const Brightness &brightness);

/// Compares the square of a patch that begins at pixel (u, v) of `image` with the square that
/// begins at `place` of `then`, which shows all of it. A pixel's difference is the mean absolute
/// difference of 3 x 3 pixels, grey values; those beyond the square's border count as the border's.
/// Where it is below `least`, it is written there, and `owner` to `owners`. Real-time safe.
void claim_pixels(GreyView image, int u, int v, GreyView then, const Eigen::Vector2f &place,
                  const Brightness &brightness, std::int32_t owner, ImageView<float> least,
                  ImageView<std::int32_t> owners);

} // namespace afterglow
