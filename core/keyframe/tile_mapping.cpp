// SPDX-License-Identifier: Apache-2.0
#include "core/keyframe/tile_mapping.hpp"

#include <Eigen/LU>

#include <algorithm>
#include <bit>

namespace afterglow {
namespace {

/// Points of a smooth tile are alike in depth: the farthest by no more than this, relative to the
/// nearest, is farther.
constexpr float alike_depths = 1.15f;
/// Points on an edge, which have an edge distance of 1, have no smooth surroundings.
constexpr int least_smooth_edge_distance = 2;
/// How far a corner's point on the surface may be seen from the corner, pixels.
constexpr float corner_tolerance_px = 0.03f;

constexpr int whole_tiles(int pixels, int size) {
    return (pixels + size - 1) / size;
}

/// A piece as a number that is the less the nearer it is, of equally near ones the earlier: the
/// bits of its depth, which is not negative, its row and its column.
constexpr std::uint64_t nearest_piece(float depth, int x, int y) {
    return std::uint64_t{std::bit_cast<std::uint32_t>(depth)} << 32 |
           static_cast<std::uint64_t>(y) << 16 | static_cast<std::uint64_t>(x);
}
constexpr float depth_of(std::uint64_t piece) {
    return std::bit_cast<float>(static_cast<std::uint32_t>(piece >> 32));
}
constexpr int row_of(std::uint64_t piece) {
    return static_cast<int>(piece >> 16 & 0xffff);
}
constexpr int column_of(std::uint64_t piece) {
    return static_cast<int>(piece & 0xffff);
}

/// The column, or row, in the middle of a piece.
constexpr float centre(int piece) {
    return (static_cast<float>(piece) + 0.5f) * SurfacePieces::piece_px - 0.5f;
}

} // namespace

TileMapping::TileMapping(const Intrinsics &from, const Intrinsics &to, int least_edge_distance_px,
                         WorkerPool &pool)
    : from_(from), to_(to),
      least_edge_distance_(std::max(least_edge_distance_px, least_smooth_edge_distance)),
      pool_(pool),
      shares_(pool, {Image<Tile>(whole_tiles(to.width, tile_px), whole_tiles(to.height, tile_px)),
                     std::vector<TileRange>(static_cast<std::size_t>(
                         whole_tiles(from.width, SurfacePieces::piece_px)))}),
      landing_ranges_(whole_tiles(from.width, SurfacePieces::piece_px),
                      whole_tiles(from.height, SurfacePieces::piece_px)),
      landing_(landing_ranges_.width(), landing_ranges_.height()),
      corners_(columns() + 1, rows() + 1) {}

void TileMapping::find(const DepthSurface &surface, const SurfaceProjection &projection,
                       const DepthCorrection &correction, float margin_px) {
    const Mapping by = {surface, projection, correction};
    put_on_tiles(by, margin_px);
    check_smooth(by);
    find_landing();
}

/// Tells each tile what is seen on it.
void TileMapping::put_on_tiles(const Mapping &by, float margin_px) {
    const auto clear = [](Share &share) { std::ranges::fill(share.tiles.pixels(), Tile{}); };
    shares_.begin();
    pool_.run_strips(landing_.height(), [&](int first, int end, int worker) {
        Share &share = shares_.use(worker, clear);
        for (int y = first; y < end; ++y) {
            find_ranges(by, margin_px, y, share.ranges);
            put_row_on_tiles(by.surface.pieces(), y, share);
        }
    });
    const std::span all = shares_.use(0, clear).tiles.pixels();
    shares_.for_each_other([&](const Share &other) {
        for (std::size_t i = 0; i < all.size(); ++i)
            add(other.tiles.pixels()[i], all[i]);
    });
}

void TileMapping::find_ranges(const Mapping &by, float margin_px, int row,
                              std::span<TileRange> ranges) {
    constexpr float size = SurfacePieces::piece_px;
    constexpr float least_margin_px = 0.25f; // points are seen a little beside where a plane's are
    const SurfacePieces &pieces = by.surface.pieces();
    const float nearest_m = 0.5f * by.surface.options().nearest_m;
    find_tile_ranges(
        {pieces.nearest().row(row), pieces.farthest().row(row), centre(0), size, landing_.width()},
        {by.projection.row(centre(row)), by.projection.while_read(), by.projection.turn(),
         nearest_m, columns(), rows(), least_margin_px, margin_px},
        ranges.data(), landing_ranges_.row(row));
}

/// A tile is smooth as long as all that is seen on it is.
void TileMapping::put_row_on_tiles(const SurfacePieces &pieces, int row, Share &share) const {
    const std::uint8_t *const edges = pieces.edge_distance().row(row);
    const float *const nearest = pieces.nearest().row(row);
    const float *const farthest = pieces.farthest().row(row);
    const TileRange *const ranges = share.ranges.data();
    const ImageView<Tile> tiles = share.tiles;
    const int least_edge_distance = least_edge_distance_;
    const int count = landing_.width();
    for (int x = 0; x < count; ++x) {
        const TileRange range = ranges[x];
        const bool smooth = edges[x] >= least_edge_distance;
        const Tile seen = {smooth ? TileContent::smooth : TileContent::mixed, edges[x], farthest[x],
                           nearest_piece(nearest[x], x, row)};
        for (int ty = range.top; ty <= range.bottom; ++ty) {
            Tile *const of_row = tiles.row(ty);
            for (int tx = range.left; tx <= range.right; ++tx)
                if (of_row[tx].content != TileContent::mixed) // which it stays
                    add(seen, of_row[tx]);
        }
    }
}

/// More that is seen on a tile, in whatever order workers come to it.
void TileMapping::add(const Tile &other, Tile &tile) {
    tile.content = std::max(tile.content, other.content);
    tile.least_edge_distance = std::min(tile.least_edge_distance, other.least_edge_distance);
    tile.farthest = std::max(tile.farthest, other.farthest);
    tile.nearest = std::min(tile.nearest, other.nearest);
}

/// Tiles that are no smooth part of a surface, though its pieces are smooth, are mixed.
void TileMapping::check_smooth(const Mapping &by) {
    pool_.run(corners_.height(), [&](int y) {
        for (int x = 0; x < corners_.width(); ++x)
            corners_(x, y) = find_corner(x, y, by);
    });
    pool_.run(rows(), [&](int y) {
        for (int x = 0; x < columns(); ++x) {
            Tile &tile = tiles()(x, y);
            if (tile.content == TileContent::smooth &&
                !(may_be_smooth(x, y) && corners_(x, y) && corners_(x + 1, y) &&
                  corners_(x, y + 1) && corners_(x + 1, y + 1)))
                tile.content = TileContent::mixed;
        }
    });
}

/// Whether a tile is all in the view, and its depths are alike.
bool TileMapping::may_be_smooth(int x, int y) const {
    const Tile &tile = tiles()(x, y);
    return tile.content == TileContent::smooth && (x + 1) * tile_px <= to_.width &&
           (y + 1) * tile_px <= to_.height &&
           tile.farthest <= alike_depths * depth_of(tile.nearest);
}

/// From the first of its tiles that may be smooth.
std::optional<MappedCorner> TileMapping::find_corner(int x, int y, const Mapping &by) const {
    for (int tile_y = std::max(y - 1, 0); tile_y <= std::min(y, rows() - 1); ++tile_y)
        for (int tile_x = std::max(x - 1, 0); tile_x <= std::min(x, columns() - 1); ++tile_x)
            if (may_be_smooth(tile_x, tile_y))
                return find_corner(x, y, tiles()(tile_x, tile_y), by);
    return std::nullopt;
}

/// The point of the surface that is seen at a corner: from the middle of the tile's nearest piece,
/// the place on the surface is corrected by how far from the corner it is seen.
std::optional<MappedCorner> TileMapping::find_corner(int x, int y, const Tile &tile,
                                                     const Mapping &by) const {
    constexpr int steps = 6, last_depth = 3;
    const ImageView<const float> depths = by.surface.z();
    const float right = static_cast<float>(from_.width - 1);
    const float bottom = static_cast<float>(from_.height - 1);
    const Eigen::Vector2f at{static_cast<float>(x * tile_px), static_cast<float>(y * tile_px)};
    const Eigen::Vector2f middle{centre(column_of(tile.nearest)), centre(row_of(tile.nearest))};
    Eigen::Vector2f place =
        at + middle - by.projection(middle.x(), middle.y(), depth_of(tile.nearest)).head<2>();
    float z = 0;
    for (int i = 0; i < steps; ++i) {
        if (!(place.x() >= 0 && place.y() >= 0 && place.x() <= right && place.y() <= bottom))
            return std::nullopt;
        if (i < last_depth) // noise of single readings must not keep it from an end
            z = depths(static_cast<int>(place.x() + 0.5f), static_cast<int>(place.y() + 0.5f));
        if (z == 0.0f)
            return std::nullopt;
        const Eigen::Vector3f seen = by.projection(place.x(), place.y(), z);
        const Eigen::Vector2f off = at - seen.head<2>();
        if (off.squaredNorm() < corner_tolerance_px * corner_tolerance_px) {
            if (seen.z() < by.surface.options().nearest_m ||
                seen.z() > by.surface.options().farthest_m)
                return std::nullopt;
            const auto line = by.projection.line(place.x(), place.y(), at.y());
            const float units =
                1000.0f / by.correction.scale(static_cast<float>((x * tile_px - to_.cx) / to_.fx),
                                              static_cast<float>((y * tile_px - to_.cy) / to_.fy));
            return MappedCorner{place.x(), place.y(), z, units * line.ray.z(),
                                units * line.shift.z()};
        }
        place += by.projection.jacobian(seen, z).inverse() * off;
    }
    return std::nullopt;
}

void TileMapping::find_landing() {
    const auto mixed_in = [&](const TileRange &range) {
        for (int y = range.top; y <= range.bottom; ++y)
            for (int x = range.left; x <= range.right; ++x)
                if (content(x, y) == TileContent::mixed)
                    return true;
        return false;
    };
    pool_.run_strips(landing_.height(), [&](int first, int end) {
        std::transform(landing_ranges_.row(first), landing_ranges_.row(end), landing_.row(first),
                       mixed_in);
    });
}

MappedTile TileMapping::mapped(int x, int y) const {
    return {{*corners_(x, y), *corners_(x + 1, y), *corners_(x, y + 1), *corners_(x + 1, y + 1)}};
}

} // namespace afterglow
