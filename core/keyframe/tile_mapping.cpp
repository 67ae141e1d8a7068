// SPDX-License-Identifier: Apache-2.0
#include "core/keyframe/tile_mapping.hpp"

#include <algorithm>

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

} // namespace

TileMapping::TileMapping(const Intrinsics &from, const Intrinsics &to, int least_edge_distance_px)
    : from_(from), to_(to),
      least_edge_distance_(std::max(least_edge_distance_px, least_smooth_edge_distance)),
      seen_(whole_tiles(from.width, SurfaceTiles::tile_px),
            whole_tiles(from.height, SurfaceTiles::tile_px)),
      landing_(seen_.width(), seen_.height()),
      tiles_(whole_tiles(to.width, tile_px), whole_tiles(to.height, tile_px)),
      corners_(tiles_.width() + 1, tiles_.height() + 1) {}

void TileMapping::find(const DepthSurface &surface, const SurfaceProjection &projection,
                       float margin_px) {
    project_pieces(surface, projection);
    put_on_tiles(surface.tiles());
    check_smooth(surface, projection);
    find_landing(margin_px);
}

void TileMapping::project_pieces(const DepthSurface &surface, const SurfaceProjection &projection) {
    const float nearest_m = surface.options().nearest_m;
    for (int y = 0; y < seen_.height(); ++y)
        for (int x = 0; x < seen_.width(); ++x)
            seen_(x, y) = project_piece(surface.tiles()(x, y), x, y, projection, nearest_m);
}

/// It is seen around the picture of its centre at its nearest and at its farthest depth, as far as
/// half its size reaches. One that is partly behind the camera may be seen anywhere.
TileMapping::SeenPiece TileMapping::project_piece(const SurfaceTile &piece, int x, int y,
                                                  const SurfaceProjection &projection,
                                                  float nearest_m) const {
    constexpr float half = SurfaceTiles::tile_px / 2.0f;
    SeenPiece seen;
    if (piece.empty())
        return seen;
    const Eigen::Vector2f centre{static_cast<float>(x * SurfaceTiles::tile_px) + half - 0.5f,
                                 static_cast<float>(y * SurfaceTiles::tile_px) + half - 0.5f};
    for (const float z : {piece.farthest, piece.nearest}) {
        const Eigen::Vector3f pixel = projection(centre.x(), centre.y(), z);
        if (!(pixel.z() > 0.5f * nearest_m)) {
            seen.in_front = false;
            continue;
        }
        const Eigen::Vector2f at = pixel.head<2>();
        const Eigen::Vector2f extent =
            half * projection.jacobian(pixel, z).cwiseAbs().rowwise().sum();
        seen.box.extend(Eigen::Vector2f(at - extent));
        seen.box.extend(Eigen::Vector2f(at + extent));
        seen.to_surface = centre - at;
    }
    if (!seen.in_front && !seen.box.isEmpty())
        seen.box = {Eigen::Vector2f(0, 0),
                    Eigen::Vector2f(static_cast<float>(to_.width), static_cast<float>(to_.height))};
    return seen;
}

/// Tells each tile what is seen on it.
void TileMapping::put_on_tiles(ImageView<const SurfaceTile> pieces) {
    constexpr float margin_px = 1; // a piece may be seen a little beside its box
    std::ranges::fill(tiles_.pixels(), Tile{});
    for (int y = 0; y < seen_.height(); ++y)
        for (int x = 0; x < seen_.width(); ++x) {
            const Eigen::AlignedBox2i on = tiles_in(seen_(x, y).box, margin_px);
            for (int ty = on.min().y(); ty <= on.max().y(); ++ty)
                for (int tx = on.min().x(); tx <= on.max().x(); ++tx)
                    add(pieces(x, y), seen_(x, y), tiles_(tx, ty));
        }
}

/// A tile is smooth as long as all that is seen on it is.
void TileMapping::add(const SurfaceTile &piece, const SeenPiece &seen, Tile &tile) const {
    const bool smooth =
        piece.whole && seen.in_front && piece.least_edge_distance >= least_edge_distance_;
    if (!smooth || tile.content == TileContent::mixed) {
        tile.content = TileContent::mixed;
        return;
    }
    if (tile.content == TileContent::nothing || piece.nearest < tile.nearest) {
        tile.nearest = piece.nearest;
        tile.to_surface = seen.to_surface;
    }
    tile.content = TileContent::smooth;
    tile.farthest = std::max(tile.farthest, piece.farthest);
    tile.least_edge_distance = std::min(tile.least_edge_distance, piece.least_edge_distance);
}

/// Tiles that are no smooth part of a surface, though its pieces are smooth, are mixed.
void TileMapping::check_smooth(const DepthSurface &surface, const SurfaceProjection &projection) {
    std::ranges::fill(corners_.pixels(), Corner{});
    for (int y = 0; y < tiles_.height(); ++y)
        for (int x = 0; x < tiles_.width(); ++x) {
            Tile &tile = tiles_(x, y);
            if (tile.content == TileContent::smooth && !is_smooth(x, y, surface, projection))
                tile.content = TileContent::mixed;
        }
}

/// Whether a tile is all in the view, its depths are alike, and its corners are on the surface.
bool TileMapping::is_smooth(int x, int y, const DepthSurface &surface,
                            const SurfaceProjection &projection) {
    const Tile &tile = tiles_(x, y);
    if ((x + 1) * tile_px > to_.width || (y + 1) * tile_px > to_.height ||
        tile.farthest > alike_depths * tile.nearest)
        return false;
    for (int i = 0; i < 4; ++i) {
        const int right = x + (i & 1), below = y + (i >> 1);
        Corner &corner = corners_(right, below);
        if (!corner.tried)
            corner = {true, find_corner({static_cast<float>(right * tile_px),
                                         static_cast<float>(below * tile_px)},
                                        tile.to_surface, surface, projection)};
        if (!corner.found)
            return false;
    }
    return true;
}

/// The point of the surface that is seen at a corner: the place of the pixel on the surface is
/// corrected by how far from the corner it is seen.
std::optional<MappedCorner> TileMapping::find_corner(const Eigen::Vector2f &at,
                                                     const Eigen::Vector2f &to_surface,
                                                     const DepthSurface &surface,
                                                     const SurfaceProjection &projection) const {
    constexpr int steps = 6, last_depth = 3;
    const float right = static_cast<float>(from_.width - 1);
    const float bottom = static_cast<float>(from_.height - 1);
    Eigen::Vector2f place = at + to_surface;
    float z = 0;
    for (int i = 0; i < steps; ++i) {
        if (!(place.x() >= 0 && place.y() >= 0 && place.x() <= right && place.y() <= bottom))
            return std::nullopt;
        if (i < last_depth) // noise of single readings must not keep it from an end
            z = surface.z()(static_cast<int>(place.x() + 0.5f), static_cast<int>(place.y() + 0.5f));
        if (z == 0.0f)
            return std::nullopt;
        const Eigen::Vector3f seen = projection(place.x(), place.y(), z);
        const Eigen::Vector2f off = at - seen.head<2>();
        if (off.squaredNorm() < corner_tolerance_px * corner_tolerance_px) {
            if (seen.z() < surface.options().nearest_m || seen.z() > surface.options().farthest_m)
                return std::nullopt;
            const auto line = projection.line(place.x(), place.y(), at.y());
            return MappedCorner{place.x(), place.y(), z, line.ray.z(), line.shift.z()};
        }
        place += projection.jacobian(seen, z).inverse() * off;
    }
    return std::nullopt;
}

void TileMapping::find_landing(float margin_px) {
    for (int y = 0; y < seen_.height(); ++y)
        for (int x = 0; x < seen_.width(); ++x) {
            const Eigen::AlignedBox2i around = tiles_in(seen_(x, y).box, margin_px);
            bool lands = false;
            for (int ty = around.min().y(); ty <= around.max().y() && !lands; ++ty)
                for (int tx = around.min().x(); tx <= around.max().x() && !lands; ++tx)
                    lands = content(tx, ty) == TileContent::mixed;
            landing_(x, y) = lands;
        }
}

/// The tiles that a box and a margin around it touch, from min() to max(); none of a box that is
/// empty or not a number.
Eigen::AlignedBox2i TileMapping::tiles_in(const Eigen::AlignedBox2f &box, float margin_px) const {
    if (!(box.min().x() <= box.max().x() && box.min().y() <= box.max().y()))
        return {};
    const auto tile = [](float at, int count) { // from -1 to count, however far away it is
        const float from_before = at / tile_px + 1;
        return static_cast<int>(std::clamp(from_before, 0.0f, static_cast<float>(count) + 1)) - 1;
    };
    const Eigen::Vector2i first{std::max(tile(box.min().x() - margin_px, columns()), 0),
                                std::max(tile(box.min().y() - margin_px, rows()), 0)};
    const Eigen::Vector2i last{std::min(tile(box.max().x() + margin_px, columns()), columns() - 1),
                               std::min(tile(box.max().y() + margin_px, rows()), rows() - 1)};
    return {first, last};
}

MappedTile TileMapping::mapped(int x, int y) const {
    return {{*corners_(x, y).found, *corners_(x + 1, y).found, *corners_(x, y + 1).found,
             *corners_(x + 1, y + 1).found}};
}

} // namespace afterglow
