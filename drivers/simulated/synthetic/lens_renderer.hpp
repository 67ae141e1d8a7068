// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "core/base/camera_model.hpp"
#include "core/base/image.hpp"
#include "core/base/rigid_motion.hpp"
#include "drivers/simulated/synthetic/motion.hpp"
#include "drivers/simulated/synthetic/pixel_rays.hpp"
#include "drivers/simulated/synthetic/scene.hpp"
#include "drivers/simulated/synthetic/surface_set.hpp"

#include <cstdint>
#include <vector>

namespace afterglow {

/// When an image is taken, and from where.
struct Shot {
    const Motion &body;         ///< what the camera is fixed to: takes its points to the world
    Pose camera_from_body = {}; ///< takes points of that body to the camera's frame
    double t_s = 0;             ///< of the middle row
    double readout_s = 0;       ///< from the first row to the last; 0 = all rows at once
};

/// Draws a scene as any camera sees it: through its lens, row after row.
///
/// The ray through each pixel's centre is met with every surface that can be there. Tiles of a few
/// rows are small enough to be taken at one moment, and a surface that misses a tile, or is behind
/// another that fills it, is sorted out for the tile as a whole: most are left with one. Pixels
/// where several surfaces are seen are sampled four times. A pixel that the lens shows nothing at
/// is black and has no depth.
class LensRenderer {
public:
    /// What is drawn besides the image.
    enum class Extra { none, normals };

    /// The scene must outlive the renderer and not change.
    LensRenderer(const Scene &scene, const CameraModel &camera, Extra extra = Extra::none);

    /// Draws into `luma`, of the camera's size; an empty view: only the depth. Allocates nothing.
    void render(const Shot &shot, ImageView<std::uint8_t> luma);

    /// Z of what was drawn last, metres; 0 where there is nothing.
    ImageView<const float> depth() const { return z_; }
    /// The surfaces' normals in the camera's frame, towards it; meaningful where there is depth.
    ImageView<const Eigen::Vector3f> normals() const { return normals_; }
    const PixelRays &rays() const { return rays_; }

private:
    struct Tile {
        int u = 0, v = 0, width = 0, height = 0;
        Box box;            ///< of its rays, and a pixel around
        bool whole = false; ///< the lens shows something at all of its pixels
    };
    void find_candidates(const Box &box);
    void draw_filled(const Tile &tile, const PlaneView &plane, ImageView<std::uint8_t> luma);
    void draw_pixels(const Tile &tile, ImageView<std::uint8_t> luma);
    int draw_pixel(int u, int v, bool shade);
    struct Seen;
    Seen look(double x, double y) const;

    SurfaceSet surfaces_;
    PixelRays rays_;
    std::vector<Tile> tiles_; ///< by rows
    struct Candidate {
        std::size_t surface;
        double highest_inverse_z;
    };
    std::vector<Candidate> candidates_; ///< what can be seen in the tile
    Image<float> z_;
    Image<Eigen::Vector3f> normals_;
};

} // namespace afterglow
