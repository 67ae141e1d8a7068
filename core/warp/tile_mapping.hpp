// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "core/base/image.hpp"
#include "core/base/worker_pool.hpp"
#include "core/base/worker_shares.hpp"
#include "core/surface/depth_surface.hpp"
#include "core/warp/corner_kernels.hpp"
#include "core/warp/mapped_tile.hpp"
#include "core/warp/surface_projection.hpp"

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

namespace afterglow {

/// What is to be seen on a tile of a view.
enum class TileContent : std::uint8_t {
    nothing, ///< no point of the surface
    mapped,  ///< points that are found by the tile's corners
    mixed,   ///< anything else
};

struct TileMappingOptions {
    /// A part of the surface in which a point is nearer to a depth edge than this, or on an edge,
    /// is not without edges.
    int least_edge_distance_px = 2;
    /// Tiles whose points hide something of each other are mapped, too: each pixel's point is
    /// searched for.
    bool search = true;
};

/// Which tiles of a view show points of a surface in the order in which they are on the surface,
/// and where the tiles' pixels are there: those need no projection of single points. Such a tile
/// shows either one part of the surface without edges, maybe with holes, or points that parallax
/// displaces by few pixels against each other, or that are searched for.
///
/// The view is parted into tiles, the surface into pieces (SurfacePieces).
///
/// Allocates when made; the calls are real-time safe.
class TileMapping {
public:
    static constexpr int tile_px = mapped_tile_px;

    TileMapping(const Intrinsics &from, const Intrinsics &to, const TileMappingOptions &options,
                WorkerPool &pool);

    /// `correction`: of the readings that corners tell; `margin_px`: what mixed tiles need to know
    /// of their surroundings.
    void find(const DepthSurface &surface, const SurfaceProjection &projection,
              const DepthCorrection &correction, float margin_px);

    int columns() const { return tiles_.width(); }
    int rows() const { return tiles_.height(); }
    TileContent content(int x, int y) const { return tiles_(x, y).content; }
    /// Of a mapped tile.
    const MappedTile &mapped(int x, int y) const { return mapped_(x, y); }
    bool any_mixed() const { return std::ranges::count(mixed_rows_, 1) > 0; }
    /// Calls visit(begin, end) for each run of pixels of the view's row v that are in mixed tiles.
    template <class Visit>
    void for_each_mixed_run(int v, const Visit &visit) const {
        const int y = v / tile_px;
        if (!mixed_row(y))
            return;
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
        constexpr int size = SurfacePieces::piece_px;
        if (landing_rows_[static_cast<std::size_t>(v / size)] == 0)
            return;
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
    /// A tile of the view.
    struct Tile {
        TileContent content = TileContent::nothing;
        /// The whole tile is in the view, and all points on it are of one surface.
        bool one_surface = false;
        bool holes = false; ///< of the surface are on it
    };
    /// Where some rows of pieces are seen.
    struct Share {
        Image<SurfacePart> seen;       ///< on each tile
        std::vector<TileRange> ranges; ///< of tiles on which each piece of a row may be seen
    };
    /// Of the corners in a row, an array for each value.
    struct CornerRow {
        ViewRays rays;
        float *millimetres;  ///< that are read for each metre of depth in the view
        float *first;        ///< where shared corners are looked for first, as find_corners() takes
        FoundCorners shared; ///< by tiles that show one surface
    };
    /// The corners of the tiles in a row.
    struct CornerRows {
        CornerRow above, below;
    };
    /// What a surface is mapped with.
    struct Mapping {
        const DepthSurface &surface;
        const SurfaceProjection &projection;
        const DepthCorrection &correction;
    };

    CornerRow corner_row(int y);
    bool mixed_row(int y) const { return mixed_rows_[static_cast<std::size_t>(y)] != 0; }
    void put_on_tiles(const Mapping &by);
    void find_ranges(const Mapping &by, float margin_px, int row,
                     std::span<TileRange> ranges) const;
    void find_rays(const Mapping &by);
    void find_contents(int y);
    void find_shared_corners(const Mapping &by, int y);
    void map_tiles(const Mapping &by);
    bool map_surface(int x, int y, const CornerRows &corners, const Mapping &by);
    bool map_by_parallax(int x, int y, const CornerRows &corners, const Mapping &by);
    static void set_parallax(int x, const CornerRows &corners, MappedTile &mapped);
    static bool may_interpolate(const Tile &tile, const DepthSurface &surface);
    bool shows_its_points(int x, int y, const CornerRows &corners,
                          const DepthSurface &surface) const;
    void find_first_depths(int y, float *depths) const;
    static std::optional<MappedCorner> corner_at(const CornerRow &row, int x, float z,
                                                 const SurfaceOptions &options);
    bool is_in_picture(const MappedCorner &corner) const;
    void find_landing(const Mapping &by, float margin_px);

    Intrinsics from_, to_;
    int least_edge_distance_;
    float most_displacement_px_; ///< of points of a mapped tile against each other
    WorkerPool &pool_;
    Image<Tile> tiles_;
    WorkerShares<Share> shares_;  ///< in the end all is in the first
    Image<std::uint8_t> landing_; ///< by piece: whether it is seen in, or around, mixed tiles
    std::vector<std::uint8_t> landing_rows_, mixed_rows_; ///< which have such pieces, tiles
    static constexpr int corner_values = 13;
    Image<float> corners_;            ///< of tiles: CornerRow's arrays, row by row
    Image<float> nearest_, farthest_; ///< SurfacePart's, of each tile, metres
    Image<float> parallax_px_;        ///< between these, as find_parallax() tells it
    /// Nearest depths, metres, of tiles that show one surface, without holes and with holes; 0 for
    /// all other tiles, and for one more tile on each side of the view.
    Image<float> whole_, holed_;
    Image<MappedTile> mapped_;
};

} // namespace afterglow
