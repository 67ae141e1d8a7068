// SPDX-License-Identifier: Apache-2.0
#include "core/keyframe/tile_mapping.hpp"

#include <algorithm>
#include <cmath>

namespace afterglow {
namespace {

/// Points of a smooth tile are alike in depth: the farthest by no more than this, relative to the
/// nearest, is farther.
constexpr float alike_depths = 1.15f;
/// Edge distance below which a tile of a surface is not smooth, pixels.
constexpr int least_smooth_edge_distance = 2;
/// How far a corner's point on the surface may be seen from the corner, pixels.
constexpr float corner_tolerance_px = 0.03f;

constexpr int whole_tiles(int pixels, int size) {
    return (pixels + size - 1) / size;
}

} // namespace

TileMapping::TileMapping(const Intrinsics &from, const Intrinsics &to)
    : from_(from), to_(to), tiles_(whole_tiles(to.width, tile_px), whole_tiles(to.height, tile_px)),
      corners_(tiles_.width() + 1, tiles_.height() + 1),
      boxes_(whole_tiles(from.width, SurfaceTiles::tile_px),
             whole_tiles(from.height, SurfaceTiles::tile_px)),
      landing_(boxes_.width(), boxes_.height()) {}

void TileMapping::find(const DepthSurface &surface, const SurfaceProjection &projection,
                       float margin_px) {
    std::ranges::fill(tiles_.pixels(), Tile{});
    std::ranges::fill(corners_.pixels(), Corner{});
    const ImageView<const SurfaceTile> pieces = surface.tiles();
    for (int y = 0; y < pieces.height(); ++y)
        for (int x = 0; x < pieces.width(); ++x) {
            const SurfaceTile &piece = pieces(x, y);
            boxes_(x, y).setEmpty();
            if (piece.empty())
                continue;
            const Outline seen_at = outline(piece, x, y, projection, surface.options().nearest_m);
            boxes_(x, y) = seen_at.box;
            const bool smooth = piece.whole && !seen_at.crosses_camera &&
                                piece.least_edge_distance >= least_smooth_edge_distance;
            const Range seen = range(boxes_(x, y), 1);
            for (int ty = seen.y0; ty <= seen.y1; ++ty)
                for (int tx = seen.x0; tx <= seen.x1; ++tx) {
                    Tile &tile = tiles_(tx, ty);
                    if (!smooth)
                        tile.content = TileContent::mixed;
                    else if (tile.content == TileContent::nothing)
                        tile = {TileContent::smooth, piece.least_edge_distance, piece.nearest,
                                piece.farthest, seen_at.to_surface};
                    if (tile.content == TileContent::mixed)
                        continue;
                    tile.farthest = std::max(tile.farthest, piece.farthest);
                    tile.least_edge_distance =
                        std::min(tile.least_edge_distance, piece.least_edge_distance);
                    if (piece.nearest < tile.nearest) {
                        tile.nearest = piece.nearest;
                        tile.to_surface = seen_at.to_surface;
                    }
                }
        }
    for (int y = 0; y < tiles_.height(); ++y)
        for (int x = 0; x < tiles_.width(); ++x) {
            Tile &tile = tiles_(x, y);
            if (tile.content != TileContent::smooth)
                continue;
            const bool inside = (x + 1) * tile_px <= to_.width && (y + 1) * tile_px <= to_.height;
            bool found = inside && tile.farthest <= alike_depths * tile.nearest;
            for (int corner = 0; found && corner < 4; ++corner)
                found = find_corner(x + (corner & 1), y + (corner >> 1), tile.to_surface, surface,
                                    projection);
            if (!found)
                tile.content = TileContent::mixed;
        }
    for (int y = 0; y < pieces.height(); ++y)
        for (int x = 0; x < pieces.width(); ++x) {
            const Range seen = range(boxes_(x, y), margin_px);
            bool lands = false;
            for (int ty = seen.y0; ty <= seen.y1 && !lands; ++ty)
                for (int tx = seen.x0; tx <= seen.x1 && !lands; ++tx)
                    lands = tiles_(tx, ty).content == TileContent::mixed;
            landing_(x, y) = lands;
        }
}

TileMapping::Range TileMapping::range(const Eigen::AlignedBox2f &box, float margin_px) const {
    const float size = tile_px;
    const auto tile = [&](float at, int count) {
        return static_cast<int>(std::clamp(at / size + 1, 0.0f, static_cast<float>(count) + 1)) - 1;
    };
    // An empty box, or one that is not a number, has no tiles.
    if (!(box.min().x() <= box.max().x() && box.min().y() <= box.max().y()))
        return {0, 0, -1, -1};
    const Range all = {
        tile(box.min().x() - margin_px, columns()), tile(box.min().y() - margin_px, rows()),
        tile(box.max().x() + margin_px, columns()), tile(box.max().y() + margin_px, rows())};
    return {std::max(all.x0, 0), std::max(all.y0, 0), std::min(all.x1, columns() - 1),
            std::min(all.y1, rows() - 1)};
}

// Its centre's picture at its nearest and at its farthest depth, and around them as much as the
// tile's half. Nothing, if it is behind the camera; the whole view, if a part of it is.
TileMapping::Outline TileMapping::outline(const SurfaceTile &tile, int x, int y,
                                          const SurfaceProjection &projection,
                                          float nearest_m) const {
    constexpr float half = SurfaceTiles::tile_px / 2.0f;
    const Eigen::Vector2f centre{static_cast<float>(x * SurfaceTiles::tile_px) + half - 0.5f,
                                 static_cast<float>(y * SurfaceTiles::tile_px) + half - 0.5f};
    Outline outline;
    for (const float z : {tile.farthest, tile.nearest}) {
        const Eigen::Vector3f seen = projection(centre.x(), centre.y(), z);
        if (!(seen.z() > 0.5f * nearest_m)) {
            if (outline.box.isEmpty())
                continue;
            outline.crosses_camera = true;
            outline.box = {Eigen::Vector2f(0, 0), Eigen::Vector2f(static_cast<float>(to_.width),
                                                                  static_cast<float>(to_.height))};
            return outline;
        }
        const Eigen::Vector2f at = seen.head<2>();
        const Eigen::Vector2f extent =
            half * projection.jacobian(seen, z).cwiseAbs().rowwise().sum();
        outline.box.extend(Eigen::Vector2f(at - extent));
        outline.box.extend(Eigen::Vector2f(at + extent));
        outline.to_surface = centre - at;
    }
    return outline;
}

/// The point of the surface that is seen at a corner: the place of the pixel on the surface is
/// corrected by how far from the corner it is seen.
bool TileMapping::find_corner(int x, int y, const Eigen::Vector2f &to_surface,
                              const DepthSurface &surface, const SurfaceProjection &projection) {
    constexpr int steps = 6, last_depth = 3;
    Corner &corner = corners_(x, y);
    if (corner.tried)
        return corner.found;
    corner.tried = true;
    const Eigen::Vector2f at{static_cast<float>(x * tile_px), static_cast<float>(y * tile_px)};
    const float right = static_cast<float>(from_.width - 1);
    const float bottom = static_cast<float>(from_.height - 1);
    Eigen::Vector2f place = at + to_surface;
    float z = 0;
    for (int i = 0; i < steps; ++i) {
        if (!(place.x() >= 0 && place.y() >= 0 && place.x() <= right && place.y() <= bottom))
            return false;
        if (i < last_depth) // noise of single readings must not keep it from an end
            z = surface.z()(static_cast<int>(place.x() + 0.5f), static_cast<int>(place.y() + 0.5f));
        if (z == 0.0f)
            return false;
        const Eigen::Vector3f seen = projection(place.x(), place.y(), z);
        const Eigen::Vector2f off = at - seen.head<2>();
        if (off.squaredNorm() < corner_tolerance_px * corner_tolerance_px) {
            const auto line = projection.line(place.x(), place.y(), at.y());
            if (seen.z() < surface.options().nearest_m || seen.z() > surface.options().farthest_m)
                return false;
            corner.u = place.x();
            corner.v = place.y();
            corner.scale = line.ray.z();
            corner.shift = line.shift.z();
            corner.z = z;
            return corner.found = true;
        }
        place += projection.jacobian(seen, z).inverse() * off;
    }
    return false;
}

MappedTile TileMapping::mapped(int x, int y) const {
    return {{corners_(x, y), corners_(x + 1, y), corners_(x, y + 1), corners_(x + 1, y + 1)}};
}

} // namespace afterglow
