// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "core/base/camera.hpp"
#include "core/base/image.hpp"
#include "core/base/rigid_motion.hpp"
#include "drivers/simulated/synthetic/scene.hpp"
#include "drivers/simulated/synthetic/surface_set.hpp"

#include <cstdint>

namespace afterglow {

/// Draws a scene as a pinhole camera sees it: the ray through each pixel's centre, met with every
/// surface.
///
/// The answer is exact, but rays are not cast one by one: of a plane the inverse depth, and the
/// texture coordinates times it, are linear in the pixel, so that each row of a rectangle is one
/// interval with nothing to be decided inside it. A row goes through the surfaces first, nearest
/// wins, and is shaded after. Pixels where two surfaces meet are sampled four times, so that
/// silhouettes move as smoothly as patterns do.
class Renderer {
public:
    /// The scene must outlive the renderer and not change.
    Renderer(const Scene &scene, const Intrinsics &camera);

    /// Draws the scene as it is at `t_s` into `luma`, of the camera's size. Allocates nothing.
    void render(double t_s, const Pose &world_to_camera, ImageView<std::uint8_t> luma);

    /// Depth of what was drawn last, metres; 0 where there is nothing.
    ImageView<const float> depth() const { return z_; }

private:
    void find_nearest(int v);
    void shade_row(int v, std::uint8_t *luma);
    void smooth_edges(ImageView<std::uint8_t> luma) const;
    std::uint8_t sample_pixel(int u, int v, std::uint8_t otherwise) const;

    SurfaceSet surfaces_;
    Intrinsics camera_;
    Image<float> inverse_z_; ///< 1/m; 0 where there is nothing
    Image<float> z_;
    Image<std::int16_t> surface_; ///< what is seen: a number in surfaces_; -1: nothing
};

} // namespace afterglow
