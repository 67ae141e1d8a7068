// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "core/base/image.hpp"
#include "core/keyframe/depth_surface.hpp"
#include "core/keyframe/surface_projection.hpp"

#include <Eigen/Core>

#include <cstdint>

namespace afterglow {

/// What is to be seen on a tile of a view.
enum class TileContent : std::uint8_t {
    nothing, ///< no point of the surface
    smooth,  ///< one surface without edges or holes, whose points change slowly across the tile
    mixed,   ///< anything else
};

/// Which tiles of a view show one smooth piece of a surface, and where its pixels are on the
/// surface: those need no projection of single points, and nothing hides anything there.
///
/// Allocates when made; the calls are real-time safe.
class TileMapping {
public:
    static constexpr int tile_px = mapped_tile_px;

    TileMapping(const Intrinsics &from, const Intrinsics &to);

    /// `margin_px`: what mixed tiles need to know of their surroundings.
    void find(const DepthSurface &surface, const SurfaceProjection &projection, float margin_px);

    int columns() const { return tiles_.width(); }
    int rows() const { return tiles_.height(); }
    TileContent content(int x, int y) const { return tiles_(x, y).content; }
    /// Least edge distance of the points on a tile, pixels.
    int least_edge_distance(int x, int y) const { return tiles_(x, y).least_edge_distance; }
    /// A smooth tile's corners.
    MappedTile mapped(int x, int y) const;
    /// Calls visit(begin, end) for each run of pixels of the view's row v that are in mixed tiles.
    template <class Visit>
    void for_each_mixed_run(int v, const Visit &visit) const {
        const int y = v / tile_px;
        for (int x = 0; x < columns(); ++x) {
            if (content(x, y) != TileContent::mixed)
                continue;
            const int begin = x;
            while (x < columns() && content(x, y) == TileContent::mixed)
                ++x;
            visit(begin * tile_px, std::min(x * tile_px, to_.width));
        }
    }
    /// The same for pixels of the surface's row v whose points may land in, or around, mixed tiles.
    template <class Visit>
    void for_each_landing_run(int v, const Visit &visit) const {
        constexpr int size = SurfaceTiles::tile_px;
        const std::uint8_t *landing = landing_.row(v / size);
        for (int x = 0; x < landing_.width(); ++x) {
            if (!landing[x])
                continue;
            const int begin = x;
            while (x < landing_.width() && landing[x])
                ++x;
            visit(begin * size, std::min(x * size, from_.width));
        }
    }

private:
    struct Tile {
        TileContent content = TileContent::nothing;
        std::uint8_t least_edge_distance = 255;
        float nearest = 0, farthest = 0;  ///< depths on the surface, metres
        Eigen::Vector2f to_surface{0, 0}; ///< shift of the nearest surface tile's centre
    };
    /// A corner of tiles of the view.
    struct Corner : MappedCorner {
        bool tried = false, found = false;
    };
    /// Tiles of the view, both ends included.
    struct Range {
        int x0, y0, x1, y1;
        bool empty() const { return x0 > x1 || y0 > y1; }
    };
    Range range(const Eigen::AlignedBox2f &box, float margin_px) const;
    /// Where a tile of the surface is seen.
    struct Outline {
        Eigen::AlignedBox2f box;
        Eigen::Vector2f to_surface{0, 0}; ///< shift of its nearest depth's picture to its centre
        bool crosses_camera = false;
    };
    Outline outline(const SurfaceTile &tile, int x, int y, const SurfaceProjection &projection,
                    float nearest_m) const;
    bool find_corner(int x, int y, const Eigen::Vector2f &to_surface, const DepthSurface &surface,
                     const SurfaceProjection &projection);

    Intrinsics from_, to_;
    Image<Tile> tiles_;
    Image<Corner> corners_;
    Image<Eigen::AlignedBox2f> boxes_; ///< of the surface's tiles, where they are seen
    Image<std::uint8_t> landing_;
};

} // namespace afterglow
