// SPDX-License-Identifier: Apache-2.0
#include "core/warp/tile_mapping.hpp"

#include "core/surface/surface_point.hpp"

#include <algorithm>
#include <limits>
#include <numbers>

namespace afterglow {
namespace {

/// Points of one surface on a tile are alike in depth: the farthest by no more than this, relative
/// to the nearest, is farther.
constexpr float alike_depths = 1.15f;
/// A tile's pixels show their points if they are no farther from them, pixels.
constexpr float place_tolerance_px = 0.5f;

constexpr int whole_tiles(int pixels, int size) {
    return (pixels + size - 1) / size;
}

/// The column, or row, in the middle of a piece.
constexpr float centre(int piece) {
    return (static_cast<float>(piece) + 0.5f) * SurfacePieces::piece_px - 0.5f;
}

} // namespace

TileMapping::TileMapping(const Intrinsics &from, const Intrinsics &to,
                         const TileMappingOptions &options, WorkerPool &pool)
    : from_(from), to_(to),
      least_edge_distance_(std::max(options.least_edge_distance_px, beside_edge)),
      most_displacement_px_(options.search ? std::numeric_limits<float>::infinity()
                                           : alike_displacement_px),
      pool_(pool), tiles_(whole_tiles(to.width, tile_px), whole_tiles(to.height, tile_px)),
      shares_(pool, {Image<SurfacePart>(columns(), rows()),
                     std::vector<TileRange>(static_cast<std::size_t>(
                         whole_tiles(from.width, SurfacePieces::piece_px)))}),
      landing_(whole_tiles(from.width, SurfacePieces::piece_px),
               whole_tiles(from.height, SurfacePieces::piece_px)),
      landing_rows_(static_cast<std::size_t>(landing_.height())),
      mixed_rows_(static_cast<std::size_t>(rows())),
      corners_(columns() + 1, corner_values * (rows() + 1)), nearest_(columns(), rows()),
      farthest_(nearest_), parallax_px_(nearest_), whole_(columns() + 2, rows() + 2),
      holed_(whole_), mapped_(columns(), rows()) {}

TileMapping::CornerRow TileMapping::corner_row(int y) {
    const auto value = [&](int i) { return corners_.row(y * corner_values + i); };
    return {.rays = {value(0), value(1), value(2), value(3), value(4), value(5)},
            .millimetres = value(6),
            .first = value(7),
            .shared = {value(8), value(9), value(10), value(11), value(12)}};
}

void TileMapping::find(const DepthSurface &surface, const SurfaceProjection &projection,
                       const DepthCorrection &correction, float margin_px) {
    const Mapping by = {surface, projection, correction};
    find_rays(by);
    put_on_tiles(by);
    map_tiles(by);
    find_landing(by, margin_px);
}

void TileMapping::find_rays(const Mapping &by) {
    const float cx = static_cast<float>(to_.cx), cy = static_cast<float>(to_.cy);
    const float per_fx = static_cast<float>(1 / to_.fx), per_fy = static_cast<float>(1 / to_.fy);
    pool_.run(rows() + 1, [&](int y) {
        const float v = static_cast<float>(y * tile_px);
        const CornerRow row = corner_row(y);
        find_view_rays(by.projection.view_row(v), tile_px, columns() + 1, row.rays);
        for (int x = 0; x <= columns(); ++x) {
            const float u = static_cast<float>(x * tile_px);
            row.millimetres[x] =
                1000.0f / by.correction.scale((u - cx) * per_fx, (v - cy) * per_fy);
        }
    });
}

/// Tells each tile what is seen on it.
void TileMapping::put_on_tiles(const Mapping &by) {
    constexpr float least_margin_px = 0.25f; // points are seen a little beside where a plane's are
    const auto clear = [](Share &share) { std::ranges::fill(share.seen.pixels(), SurfacePart{}); };
    shares_.begin();
    pool_.run_strips(landing_.height(), [&](int first, int end, int worker) {
        Share &share = shares_.use(worker, clear);
        for (int y = first; y < end; ++y) {
            find_ranges(by, least_margin_px, y, share.ranges);
            add_to_tiles(by.surface.pieces().parts().row(y), share.ranges, share.seen);
        }
    });
    Share &all = shares_.use(0, clear);
    pool_.run(rows(), [&](int y) {
        shares_.for_each_other([&](const Share &other) {
            for (int x = 0; x < columns(); ++x)
                all.seen(x, y).add(other.seen(x, y));
        });
        find_contents(y);
    });
}

void TileMapping::find_ranges(const Mapping &by, float margin_px, int row,
                              std::span<TileRange> ranges) const {
    constexpr float size = SurfacePieces::piece_px;
    const SurfacePieces &pieces = by.surface.pieces();
    const float nearest_m = 0.5f * by.surface.options().nearest_m;
    find_tile_ranges(
        {pieces.nearest().row(row), pieces.farthest().row(row), centre(0), size, landing_.width()},
        {by.projection.row(centre(row)), by.projection.while_read(), by.projection.turn(),
         nearest_m, columns(), rows(), margin_px},
        ranges.data());
}

/// Tells what may be seen on the tiles of a row, if they can be mapped.
void TileMapping::find_contents(int y) {
    float *const nearest = nearest_.row(y), *const farthest = farthest_.row(y);
    float *const whole = whole_.row(y + 1) + 1, *const holed = holed_.row(y + 1) + 1;
    const SurfacePart *const seen = shares_.first().seen.row(y);
    for (int x = 0; x < columns(); ++x) {
        nearest[x] = seen[x].nearest();
        farthest[x] = seen[x].farthest();
    }
    float *const parallax_px = parallax_px_.row(y);
    find_parallax(
        {corner_row(y).rays, corner_row(y + 1).rays.from(1), nearest, farthest, columns()},
        parallax_px);
    for (int x = 0; x < columns(); ++x) {
        Tile &tile = tiles_(x, y);
        tile = {};
        whole[x] = holed[x] = 0;
        if (farthest[x] == 0.0f)
            continue;
        const bool in_view = (x + 1) * tile_px <= to_.width && (y + 1) * tile_px <= to_.height;
        tile.holes = seen[x].holes();
        tile.one_surface = in_view && seen[x].least_edge_distance() >= least_edge_distance_ &&
                           farthest[x] <= alike_depths * nearest[x];
        tile.content = in_view && (parallax_px[x] < most_displacement_px_ || tile.one_surface)
                           ? TileContent::mapped
                           : TileContent::mixed;
        if (tile.one_surface)
            (tile.holes ? holed : whole)[x] = nearest[x];
    }
}

/// Tiles that would be mapped, but whose corners are not found, are mixed.
void TileMapping::map_tiles(const Mapping &by) {
    pool_.run(rows() + 1, [&](int y) { find_shared_corners(by, y); });
    pool_.run(rows(), [&](int y) {
        const CornerRows corners = {corner_row(y), corner_row(y + 1)};
        bool mixed = false;
        for (int x = 0; x < columns(); ++x) {
            Tile &tile = tiles_(x, y);
            if (tile.content == TileContent::mapped && !map_surface(x, y, corners, by) &&
                !map_by_parallax(x, y, corners, by))
                tile.content = TileContent::mixed;
            mixed = mixed || tile.content == TileContent::mixed;
        }
        mixed_rows_[static_cast<std::size_t>(y)] = mixed;
    });
}

/// By corners that are shared with other tiles, if they are those of the tile's surface.
bool TileMapping::map_surface(int x, int y, const CornerRows &corners, const Mapping &by) {
    const Tile &tile = tiles_(x, y);
    if (!tile.one_surface)
        return false;
    MappedTile &mapped = mapped_(x, y);
    for (int i = 0; i < 4; ++i) {
        const FoundCorners &found = (i < 2 ? corners.above : corners.below).shared;
        const int at = x + i % 2;
        if (found.z[at] == 0.0f)
            return false;
        mapped.corners[i] = {found.u[at], found.v[at], found.z[at], found.scale[at],
                             found.shift[at]};
    }
    mapped.one_surface = true;
    mapped.interpolated = may_interpolate(tile, by.surface);
    mapped.searched = false;
    set_parallax(x, corners, mapped);
    const auto in_picture = [&](const MappedCorner &corner) { return is_in_picture(corner); };
    return (!tile.holes && std::ranges::all_of(mapped.corners, in_picture)) ||
           shows_its_points(x, y, corners, by.surface);
}

/// By corners of its own: those of the nearest depth, if points have to be searched for; else those
/// of the mean of the nearest and the farthest point's inverse depths.
bool TileMapping::map_by_parallax(int x, int y, const CornerRows &corners, const Mapping &by) {
    const Tile &tile = tiles_(x, y);
    const float parallax_px = parallax_px_(x, y);
    if (!(parallax_px < most_displacement_px_))
        return false;
    const float near = nearest_(x, y), far = farthest_(x, y);
    MappedTile &mapped = mapped_(x, y);
    mapped.one_surface = false;
    mapped.interpolated = may_interpolate(tile, by.surface);
    mapped.searched = parallax_px >= alike_displacement_px;
    const float z = mapped.searched ? near : 2 * near * far / (near + far);
    mapped.inverse_depth = 1 / z;
    mapped.farthest_inverse_depth = 1 / far;
    set_parallax(x, corners, mapped);
    for (int i = 0; i < 4; ++i) {
        const auto corner =
            corner_at(i < 2 ? corners.above : corners.below, x + i % 2, z, by.surface.options());
        if (!corner)
            return false;
        mapped.corners[i] = *corner;
    }
    return true;
}

/// That in the middle of the tile.
void TileMapping::set_parallax(int x, const CornerRows &corners, MappedTile &mapped) {
    const ViewRays &above = corners.above.rays, &below = corners.below.rays;
    mapped.parallax_u = -0.5f * (above.parallax_u[x] + below.parallax_u[x + 1]);
    mapped.parallax_v = -0.5f * (above.parallax_v[x] + below.parallax_v[x + 1]);
}

/// Whether the tile's readings may be interpolated between nodes, which draws over
/// holes of up to 3 pixels: if the tile has no holes, or if cracks of up to 2 pixels are filled
/// anyway.
bool TileMapping::may_interpolate(const Tile &tile, const DepthSurface &surface) {
    static_assert(widest_crack_px + 1 == mapped_block_px - 1);
    return !tile.holes || surface.options().crack_px == widest_crack_px;
}

/// Whether what is between a tile's corners is seen where it is drawn.
bool TileMapping::shows_its_points(int x, int y, const CornerRows &rows,
                                   const DepthSurface &surface) const {
    constexpr int across = 4;
    constexpr float step = 1.0f / across;
    const ImageView<const float> depths = surface.z();
    const auto &corners = mapped_(x, y).corners;
    // Of each corner: the place on the surface, the parallax, and what that is at its depth.
    using Values = Eigen::Array<float, 6, 1>;
    const auto parallax_at = [&](int i, int j) -> Eigen::Vector2f {
        const ViewRays &rays = (j == 0 ? rows.above : rows.below).rays;
        return {rays.parallax_u[x + i], rays.parallax_v[x + i]};
    };
    const auto at_corner = [&](int i, int j) {
        const MappedCorner &corner = corners[2 * j + i];
        const Eigen::Vector2f parallax = parallax_at(i, j);
        Values values;
        values << corner.u, corner.v, parallax, parallax / corner.z;
        return values;
    };
    const Values a = at_corner(0, 0), b = at_corner(1, 0), c = at_corner(0, 1), e = at_corner(1, 1);
    const float tolerance_px = place_tolerance_px / tile_px * (e - a).head<2>().matrix().norm() /
                               std::numbers::sqrt2_v<float>; // on the surface
    const auto least = [&](auto depth) {
        return std::min({depth(0), depth(1), depth(2), depth(3)});
    };
    const float near = std::min(nearest_(x, y), least([&](int i) { return corners[i].z; }));
    const float far = std::max(farthest_(x, y), -least([&](int i) { return -corners[i].z; }));
    if ((1 / near - 1 / far) * parallax_at(0, 0).norm() < tolerance_px)
        return true;
    for (int j = 0; j < across; ++j) {
        const float down = (static_cast<float>(j) + 0.5f) * step;
        const Values left = a + down * (c - a), right = b + down * (e - b);
        const Values to_next = step * (right - left);
        Values at = left - 0.5f * to_next;
        for (int i = 0; i < across; ++i) {
            at += to_next;
            if (!(at[0] > -0.5f && at[1] > -0.5f))
                continue;
            const int u = static_cast<int>(at[0] + 0.5f), v = static_cast<int>(at[1] + 0.5f);
            if (!depths.contains(u, v) || depths(u, v) == 0.0f)
                continue;
            const float inverse = 1 / depths(u, v);
            const float off_u = inverse * at[2] - at[4], off_v = inverse * at[3] - at[5];
            if (off_u * off_u + off_v * off_v > tolerance_px * tolerance_px)
                return false;
        }
    }
    return true;
}

/// The depths, metres, with which the search for the corners of row y begins: for each corner the
/// nearest depth of the first of its four tiles that shows one surface without holes; if none does,
/// of the first that shows one with holes; 0 if none does that either.
void TileMapping::find_first_depths(int y, float *depths) const {
    const float *const whole_above = whole_.row(y), *const whole_below = whole_.row(y + 1);
    const float *const holed_above = holed_.row(y), *const holed_below = holed_.row(y + 1);
    const auto first_of = [](float first, float second) { return first != 0.0f ? first : second; };
    for (int x = 0; x <= columns(); ++x) { // the compiler makes vector code of it
        const auto beside = [&](const float *above, const float *below) {
            return first_of(first_of(above[x], above[x + 1]), first_of(below[x], below[x + 1]));
        };
        depths[x] = first_of(beside(whole_above, whole_below), beside(holed_above, holed_below));
    }
}

/// Finds the corners in a row that are shared by tiles, beginning with the nearest point of one.
void TileMapping::find_shared_corners(const Mapping &by, int y) {
    const CornerRow row = corner_row(y);
    find_first_depths(y, row.first);
    const SurfaceOptions &options = by.surface.options();
    find_corners({by.surface.z(), by.surface.pieces(), options.nearest_m, options.farthest_m},
                 row.rays, row.first, row.millimetres, columns() + 1, row.shared);
}

/// The point of the surface that is seen at a corner, if its depth is z.
std::optional<MappedCorner> TileMapping::corner_at(const CornerRow &row, int x, float z,
                                                   const SurfaceOptions &options) {
    const float scale = row.rays.scale[x], shift = row.rays.shift[x];
    const float depth = scale * z + shift, inverse = 1 / z;
    if (!(depth >= options.nearest_m && depth <= options.farthest_m))
        return std::nullopt;
    return MappedCorner{row.rays.infinite_u[x] + inverse * row.rays.parallax_u[x],
                        row.rays.infinite_v[x] + inverse * row.rays.parallax_v[x], z,
                        row.millimetres[x] * scale, row.millimetres[x] * shift};
}

bool TileMapping::is_in_picture(const MappedCorner &corner) const {
    return corner.u >= 0 && corner.v >= 0 && corner.u <= static_cast<float>(from_.width - 1) &&
           corner.v <= static_cast<float>(from_.height - 1);
}

/// Which pieces may land in or around mixed tiles.
void TileMapping::find_landing(const Mapping &by, float margin_px) {
    const auto mixed_in = [&](const TileRange &range) {
        for (int y = range.top; y <= range.bottom; ++y)
            for (int x = range.left; mixed_row(y) && x <= range.right; ++x)
                if (content(x, y) == TileContent::mixed)
                    return true;
        return false;
    };
    if (!any_mixed()) {
        std::ranges::fill(landing_rows_, std::uint8_t{0});
        return;
    }
    pool_.run_strips(landing_.height(), [&](int first, int end, int worker) {
        std::vector<TileRange> &ranges = shares_.use(worker, [](Share &) {}).ranges;
        for (int y = first; y < end; ++y) {
            find_ranges(by, margin_px, y, ranges);
            std::transform(ranges.begin(), ranges.end(), landing_.row(y), mixed_in);
            landing_rows_[static_cast<std::size_t>(y)] = static_cast<std::uint8_t>(
                std::count(landing_.row(y), landing_.row(y) + landing_.width(), 1) > 0);
        }
    });
}

} // namespace afterglow
