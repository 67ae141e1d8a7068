// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "core/base/image.hpp"
#include "core/base/worker_pool.hpp"
#include "core/base/worker_shares.hpp"
#include "core/keyframe/depth_surface.hpp"
#include "core/keyframe/surface_projection.hpp"

#include <Eigen/Core>

#include <algorithm>
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

namespace afterglow {

/// What is to be seen on a tile of a view; of two findings the greater counts.
enum class TileContent : std::uint8_t {
    nothing, ///< no point of the surface
    smooth,  ///< one surface without edges or holes, whose points change slowly across the tile
    mixed,   ///< anything else
};

/// Which tiles of a view show one smooth part of a surface, and where their pixels are on the
/// surface: those need no projection of single points, and nothing hides anything there.
///
/// The view is parted into tiles, the surface into pieces (SurfacePieces).
///
/// Allocates when made; the calls are real-time safe.
class TileMapping {
public:
    static constexpr int tile_px = mapped_tile_px;

    /// Smooth tiles show no point nearer to a depth edge than `least_edge_distance_px`, and none on
    /// an edge.
    TileMapping(const Intrinsics &from, const Intrinsics &to, int least_edge_distance_px,
                WorkerPool &pool);

    /// `correction`: of the readings that corners tell; `margin_px`: what mixed tiles need to know
    /// of their surroundings.
    void find(const DepthSurface &surface, const SurfaceProjection &projection,
              const DepthCorrection &correction, float margin_px);

    int columns() const { return tiles().width(); }
    int rows() const { return tiles().height(); }
    TileContent content(int x, int y) const { return tiles()(x, y).content; }
    /// Least edge distance of the points on a smooth tile, pixels.
    int least_edge_distance(int x, int y) const { return tiles()(x, y).least_edge_distance; }
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
        constexpr int size = SurfacePieces::piece_px;
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
    /// What is known of a tile of the view.
    struct Tile {
        TileContent content = TileContent::nothing;
        std::uint8_t least_edge_distance = 255;
        float farthest = 0;            ///< depth on the surface, metres
        std::uint64_t nearest = ~0ULL; ///< piece, as of nearest_piece()
    };
    /// What some rows of pieces are seen on.
    struct Share {
        Image<Tile> tiles;
        std::vector<TileRange> ranges; ///< on which each piece of a row may be seen
    };
    /// What a surface is mapped with.
    struct Mapping {
        const DepthSurface &surface;
        const SurfaceProjection &projection;
        const DepthCorrection &correction;
    };

    Image<Tile> &tiles() { return shares_.first().tiles; }
    const Image<Tile> &tiles() const { return shares_.first().tiles; }
    void put_on_tiles(const Mapping &by, float margin_px);
    void find_ranges(const Mapping &by, float margin_px, int row, std::span<TileRange> ranges);
    void put_row_on_tiles(const SurfacePieces &pieces, int row, Share &share) const;
    static void add(const Tile &other, Tile &tile);
    void check_smooth(const Mapping &by);
    bool may_be_smooth(int x, int y) const;
    std::optional<MappedCorner> find_corner(int x, int y, const Mapping &by) const;
    std::optional<MappedCorner> find_corner(int x, int y, const Tile &tile,
                                            const Mapping &by) const;
    void find_landing();

    Intrinsics from_, to_;
    int least_edge_distance_;
    WorkerPool &pool_;
    WorkerShares<Share> shares_;      ///< in the end all is in the first
    Image<TileRange> landing_ranges_; ///< on which each piece may be seen, with a margin
    Image<std::uint8_t> landing_;     ///< by piece: whether it is seen in, or around, mixed tiles
    Image<std::optional<MappedCorner>> corners_; ///< of tiles that may be smooth
};

} // namespace afterglow
