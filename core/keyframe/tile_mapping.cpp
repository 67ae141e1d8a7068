// SPDX-License-Identifier: Apache-2.0
#include "core/keyframe/tile_mapping.hpp"

#include "core/keyframe/surface_point.hpp"

#include <Eigen/LU>

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <cstdlib>

namespace afterglow {
namespace {

/// Points of one surface on a tile are alike in depth: the farthest by no more than this, relative
/// to the nearest, is farther.
constexpr float alike_depths = 1.15f;
/// Points that are displaced by no more than this against each other hide nothing of each other,
/// pixels.
constexpr float alike_displacement_px = 1.0f;
/// A tile's pixels show their points if they are no farther from them, pixels.
constexpr float place_tolerance_px = 0.5f;
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
constexpr float depth_of(std::uint32_t bits) {
    return std::bit_cast<float>(bits);
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
    : from_(from), to_(to), least_edge_distance_(std::max(least_edge_distance_px, beside_edge)),
      pool_(pool),
      shares_(pool, {Image<Tile>(whole_tiles(to.width, tile_px), whole_tiles(to.height, tile_px)),
                     std::vector<TileRange>(static_cast<std::size_t>(
                         whole_tiles(from.width, SurfacePieces::piece_px)))}),
      landing_ranges_(whole_tiles(from.width, SurfacePieces::piece_px),
                      whole_tiles(from.height, SurfacePieces::piece_px)),
      landing_(landing_ranges_.width(), landing_ranges_.height()),
      corners_(columns() + 1, rows() + 1), mapped_(columns(), rows()) {}

void TileMapping::find(const DepthSurface &surface, const SurfaceProjection &projection,
                       const DepthCorrection &correction, float margin_px) {
    const Mapping by = {surface, projection, correction};
    put_on_tiles(by, margin_px);
    map_tiles(by);
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
    shares_.use(0, clear);
    pool_.run(rows(), [&](int y) {
        shares_.for_each_other([&](const Share &other) {
            for (int x = 0; x < columns(); ++x)
                add(other.tiles(x, y), tiles()(x, y));
        });
        for (int x = 0; x < columns(); ++x)
            find_content(x, y, by);
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

void TileMapping::put_row_on_tiles(const SurfacePieces &pieces, int row, Share &share) const {
    const std::uint8_t *const edges = pieces.edges().row(row);
    const float *const nearest = pieces.nearest().row(row);
    const float *const farthest = pieces.farthest().row(row);
    const std::span ranges = share.ranges;
    const ImageView<Tile> tiles = share.tiles;
    const auto piece = [&](std::size_t x) {
        Tile seen;
        seen.nearest = nearest_piece(nearest[x], static_cast<int>(x), row);
        seen.farthest = std::bit_cast<std::uint32_t>(farthest[x]);
        seen.least_edge_distance = edges[x] & edge_distance_bits;
        seen.holes = edges[x] & SurfacePieces::has_holes;
        return seen;
    };
    for (std::size_t x = 0; x < ranges.size(); ++x) {
        const TileRange range = ranges[x];
        if (range.left > range.right || range.top > range.bottom)
            continue;
        Tile seen = piece(x);
        for (; x + 1 < ranges.size() && ranges[x + 1] == range; ++x) // on the same tiles
            add(piece(x + 1), seen);
        for (int ty = range.top; ty <= range.bottom; ++ty) {
            Tile *const of_row = tiles.row(ty);
            for (int tx = range.left; tx <= range.right; ++tx)
                add(seen, of_row[tx]);
        }
    }
}

/// More that is seen on a tile, in whatever order workers come to it.
void TileMapping::add(const Tile &other, Tile &tile) {
    tile.nearest = std::min(tile.nearest, other.nearest);
    tile.farthest = std::max(tile.farthest, other.farthest);
    tile.least_edge_distance = std::min(tile.least_edge_distance, other.least_edge_distance);
    tile.holes |= other.holes;
}

/// Tells what may be seen on a tile, if it can be mapped.
void TileMapping::find_content(int x, int y, const Mapping &by) {
    Tile &tile = tiles()(x, y);
    if (tile.farthest == 0)
        return;
    const float u = centre(column_of(tile.nearest)), v = centre(row_of(tile.nearest));
    const Eigen::Vector3f nearest = by.projection(u, v, depth_of(tile.nearest));
    const Eigen::Vector3f farthest = by.projection(u, v, depth_of(tile.farthest));
    tile.displaced_alike = (farthest - nearest).head<2>().squaredNorm() <
                           alike_displacement_px * alike_displacement_px;
    const bool in_view = (x + 1) * tile_px <= to_.width && (y + 1) * tile_px <= to_.height;
    tile.content = in_view && (tile.displaced_alike || one_surface(tile)) ? TileContent::mapped
                                                                          : TileContent::mixed;
}

bool TileMapping::one_surface(const Tile &tile) const {
    return tile.least_edge_distance >= least_edge_distance_ &&
           depth_of(tile.farthest) <= alike_depths * depth_of(tile.nearest);
}

/// Tiles that would be mapped, but whose corners are not found, are mixed.
void TileMapping::map_tiles(const Mapping &by) {
    pool_.run(corners_.height(), [&](int y) {
        for (int x = 0; x < corners_.width(); ++x)
            corners_(x, y) = find_shared_corner(x, y, by);
    });
    pool_.run(rows(), [&](int y) {
        for (int x = 0; x < columns(); ++x) {
            Tile &tile = tiles()(x, y);
            if (tile.content == TileContent::mapped && !map_surface(x, y, by) &&
                !map_alike(x, y, by))
                tile.content = TileContent::mixed;
        }
    });
}

/// By corners that are shared with other tiles, if they are those of the tile's surface.
bool TileMapping::map_surface(int x, int y, const Mapping &by) {
    const Tile &tile = tiles()(x, y);
    const auto &a = corners_(x, y), &b = corners_(x + 1, y);
    const auto &c = corners_(x, y + 1), &e = corners_(x + 1, y + 1);
    if (!(one_surface(tile) && a && b && c && e))
        return false;
    MappedTile &mapped = mapped_(x, y);
    mapped = {};
    std::ranges::copy(std::array{*a, *b, *c, *e}, mapped.corners);
    mapped.in_picture = in_picture(*a) && in_picture(*b) && in_picture(*c) && in_picture(*e);
    const bool whole = tile.holes == 0 && mapped.in_picture;
    mapped.even = whole && tile.least_edge_distance >= far_from_edge;
    return whole || shows_its_points(x, y, by);
}

/// By corners of its own, at the mean of the nearest and the farthest point's inverse depths, if
/// points are displaced alike.
bool TileMapping::map_alike(int x, int y, const Mapping &by) {
    const Tile &tile = tiles()(x, y);
    if (!tile.displaced_alike)
        return false;
    const float near = depth_of(tile.nearest), far = depth_of(tile.farthest);
    const float z = 2 * near * far / (near + far);
    MappedTile &mapped = mapped_(x, y);
    mapped = {};
    mapped.one_surface = false;
    mapped.inverse_depth = 1 / z;
    if (far > near) {
        const float u = centre(column_of(tile.nearest)), v = centre(row_of(tile.nearest));
        const Eigen::Vector3f seen = by.projection(u, v, near);
        const Eigen::Vector3f displaced = seen - by.projection(u, v, far);
        const Eigen::Vector2f parallax = by.projection.jacobian(seen, near).inverse() *
                                         displaced.head<2>() / (1 / near - 1 / far);
        mapped.parallax_u = parallax.x();
        mapped.parallax_v = parallax.y();
    }
    for (int i = 0; i < 4; ++i) {
        const auto corner = find_corner(x + i % 2, y + i / 2, tile, by,
                                        [z](const Eigen::Vector2f & /*place*/) { return z; });
        if (!corner)
            return false;
        mapped.corners[i] = *corner;
        mapped.in_picture = mapped.in_picture && in_picture(*corner);
    }
    return true;
}

/// Whether what is between a tile's corners is seen where it is drawn.
bool TileMapping::shows_its_points(int x, int y, const Mapping &by) const {
    constexpr int across = 4, step = tile_px / across;
    const ImageView<const float> depths = by.surface.z();
    const MappedTile &tile = mapped_(x, y);
    const auto place = [&](int i) -> Eigen::Vector2f {
        return {tile.corners[i].u, tile.corners[i].v};
    };
    const Eigen::Vector2f first(static_cast<float>(x * tile_px), static_cast<float>(y * tile_px));
    for (int j = 0; j < across; ++j)
        for (int i = 0; i < across; ++i) {
            const Eigen::Vector2f at{(static_cast<float>(i) + 0.5f) * step,
                                     (static_cast<float>(j) + 0.5f) * step};
            const Eigen::Vector2f share = at / tile_px;
            const Eigen::Vector2f above = place(0) + share.x() * (place(1) - place(0));
            const Eigen::Vector2f below = place(2) + share.x() * (place(3) - place(2));
            const Eigen::Vector2f on_surface = above + share.y() * (below - above);
            const int u = static_cast<int>(std::lround(on_surface.x()));
            const int v = static_cast<int>(std::lround(on_surface.y()));
            if (!depths.contains(u, v) || depths(u, v) == 0.0f)
                continue;
            const Eigen::Vector3f seen =
                by.projection(on_surface.x(), on_surface.y(), depths(u, v));
            if ((seen.head<2>() - first - at).squaredNorm() >
                place_tolerance_px * place_tolerance_px)
                return false;
        }
    return true;
}

/// The tile by which a corner is found, among those that it is a corner of: the first that shows
/// one surface, without holes if there is one.
const TileMapping::Tile *TileMapping::tile_at_corner(int x, int y) const {
    const Tile *found = nullptr;
    for (int tile_y = std::max(y - 1, 0); tile_y <= std::min(y, rows() - 1); ++tile_y)
        for (int tile_x = std::max(x - 1, 0); tile_x <= std::min(x, columns() - 1); ++tile_x) {
            const Tile &tile = tiles()(tile_x, tile_y);
            if (tile.content != TileContent::mapped || !one_surface(tile))
                continue;
            if (tile.holes == 0)
                return &tile;
            found = found ? found : &tile;
        }
    return found;
}

/// By the depths that the surface has there.
std::optional<MappedCorner> TileMapping::find_shared_corner(int x, int y, const Mapping &by) const {
    constexpr int lookups = 3; // noise of single readings must not keep the corner from an end
    const Tile *const tile = tile_at_corner(x, y);
    if (!tile)
        return std::nullopt;
    float z = 0;
    int left = lookups;
    return find_corner(x, y, *tile, by, [&](const Eigen::Vector2f &place) {
        if (left > 0)
            z = depth_near(place, by.surface);
        --left;
        return z;
    });
}

/// The point of the surface that is seen at a corner: from the middle of the tile's nearest piece,
/// the place on the surface is corrected by how far from the corner it is seen. It may be outside
/// of the surface's picture.
template <class DepthAt>
std::optional<MappedCorner> TileMapping::find_corner(int x, int y, const Tile &tile,
                                                     const Mapping &by,
                                                     const DepthAt &depth_at) const {
    constexpr int steps = 6;
    const SurfaceOptions &options = by.surface.options();
    const Eigen::Vector2f at{static_cast<float>(x * tile_px), static_cast<float>(y * tile_px)};
    const Eigen::Vector2f middle{centre(column_of(tile.nearest)), centre(row_of(tile.nearest))};
    Eigen::Vector2f place =
        at + middle - by.projection(middle.x(), middle.y(), depth_of(tile.nearest)).head<2>();
    for (int i = 0; i < steps; ++i) {
        const float z = depth_at(place);
        if (z == 0.0f)
            return std::nullopt;
        const Eigen::Vector3f seen = by.projection(place.x(), place.y(), z);
        const Eigen::Vector2f off = at - seen.head<2>();
        if (off.squaredNorm() < corner_tolerance_px * corner_tolerance_px) {
            if (seen.z() < options.nearest_m || seen.z() > options.farthest_m)
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

bool TileMapping::in_picture(const MappedCorner &corner) const {
    return corner.u >= 0 && corner.v >= 0 && corner.u <= static_cast<float>(from_.width - 1) &&
           corner.v <= static_cast<float>(from_.height - 1);
}

/// The depth at a place on the surface or, if that is a hole or outside, of one of the nearest
/// pieces around that have any; 0 if there is none nearby.
float TileMapping::depth_near(const Eigen::Vector2f &place, const DepthSurface &surface) const {
    constexpr int reach = 3; // pieces
    const float right = static_cast<float>(from_.width - 1);
    const float bottom = static_cast<float>(from_.height - 1);
    if (!(place.x() > -tile_px && place.y() > -tile_px && place.x() < right + tile_px &&
          place.y() < bottom + tile_px))
        return 0;
    const int u = static_cast<int>(std::clamp(place.x(), 0.0f, right) + 0.5f);
    const int v = static_cast<int>(std::clamp(place.y(), 0.0f, bottom) + 0.5f);
    if (const float z = surface.z()(u, v); z != 0.0f)
        return z;
    const ImageView<const float> depths = surface.pieces().nearest();
    const int column = u / SurfacePieces::piece_px, row = v / SurfacePieces::piece_px;
    for (int ring = 0; ring <= reach; ++ring)
        for (int y = row - ring; y <= row + ring; ++y) {
            const int step = std::abs(y - row) == ring ? 1 : std::max(2 * ring, 1);
            for (int x = column - ring; x <= column + ring; x += step)
                if (depths.contains(x, y) && depths(x, y) != 0.0f)
                    return depths(x, y);
        }
    return 0;
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

} // namespace afterglow
