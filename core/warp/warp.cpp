// SPDX-License-Identifier: Apache-2.0
#include "core/warp/warp.hpp"

#include "core/surface/cracks.hpp"
#include "core/warp/warp_kernels.hpp"

#include <algorithm>
#include <array>
#include <atomic>
#include <cassert>
#include <cmath>
#include <cstring>
#include <hwy/cache_control.h>
#include <span>

namespace afterglow {
namespace {

/// Of the values that land on a pixel the least stays.
void keep_nearest(std::span<const int> offsets, const WarpedPixel *values, WarpedPixel *to) {
    for (const int offset : offsets) {
        const WarpedPixel value = *values++;
        if (value < to[offset])
            to[offset] = value;
    }
}

} // namespace

Warp::Warp(const Intrinsics &from, const Intrinsics &to, const WarpOptions &options,
           WorkerPool &pool)
    : from_(from), to_(to), options_(options), pool_(pool),
      tiles_(from, to, {options.least_edge_distance_px, !options.edges_hide}, pool),
      grid_(to.width, to.height), readings_(tiles_.columns(), tiles_.rows()),
      nearest_(pool, Image<WarpedPixel>(to.width + 2 * margin, to.height + 2 * margin)) {}

ImageView<const WarpedPixel> Warp::landed() const {
    const Image<WarpedPixel> &nearest = nearest_.first();
    return {nearest.row(margin) + margin, to_.width, to_.height, nearest.width()};
}

int Warp::run(const DepthSurface &surface, const Pose &pose, ImageView<std::uint16_t> depth,
              ImageView<std::uint8_t> edge_distance, const DepthCorrection &correction,
              const RollingShutter &shutter) {
    assert(depth.width() == to_.width && depth.height() == to_.height &&
           edge_distance.same_size(depth));
    const SurfaceProjection projection(from_, to_, pose, shutter);
    tiles_.find(surface, projection, correction,
                static_cast<float>(surface.options().crack_px + 1));
    if (tiles_.any_mixed())
        scatter(surface, projection);
    pool_.run(grid_.rows(), [&](int y) { look_up_nodes(surface, y); });
    std::atomic<int> drawn = 0;
    pool_.run(tiles_.rows(), [&](int y) {
        drawn.fetch_add(draw_tiles({surface, correction, depth, edge_distance}, y),
                        std::memory_order_relaxed);
    });
    return drawn;
}

void Warp::scatter(const DepthSurface &surface, const SurfaceProjection &projection) {
    const auto clear = [](Image<WarpedPixel> &nearest) {
        std::ranges::fill(nearest.pixels(), nothing_landed);
    };
    nearest_.begin();
    pool_.run_strips(from_.height, [&](int first, int end, int worker) {
        scatter_rows(surface, projection, first, end, nearest_.use(worker, clear));
    });
    Image<WarpedPixel> &all = nearest_.use(0, clear);
    pool_.run_strips(all.height(), [&](int first, int end) {
        nearest_.for_each_other([&](const Image<WarpedPixel> &other) {
            const WarpedPixel *const in = other.row(first);
            WarpedPixel *const out = all.row(first);
            const int count = (end - first) * all.width();
            for (int i = 0; i < count; ++i) // the compiler makes vector code of it
                out[i] = std::min(out[i], in[i]);
        });
    });
}

void Warp::scatter_rows(const DepthSurface &surface, const SurfaceProjection &projection,
                        int first_row, int end_row, Image<WarpedPixel> &nearest) const {
    constexpr int most = most_points;
    const LandingLimits limits = {surface.options().nearest_m,
                                  surface.options().farthest_m,
                                  static_cast<float>(to_.width),
                                  static_cast<float>(to_.height),
                                  options_.edges_hide ? 1 : options_.least_edge_distance_px,
                                  options_.edges_hide ? options_.least_edge_distance_px : 0,
                                  nearest.width()};
    WarpedPixel *const to = nearest.row(margin) + margin;
    const int w = from_.width, last = from_.height - 1;
    std::array<float, most + 2> z;
    std::array<int, most> offsets;
    std::array<WarpedPixel, most> values;
    for (int v = first_row; v < end_row; ++v) {
        const RowProjection row = projection.row(static_cast<float>(v));
        const float *z_row = surface.z().row(v);
        const float *z_up = surface.z().row(std::max(v - 1, 0));
        const float *z_down = surface.z().row(std::min(v + 1, last));
        const auto project = [&](int u, int count) {
            const float *with_sides = z_row + u - 1;
            if (u == 0 || u + count == w) { // beyond the picture there is no depth
                z.front() = u > 0 ? z_row[u - 1] : 0.0f;
                std::copy_n(z_row + u, count, z.begin() + 1);
                z[static_cast<std::size_t>(count) + 1] = u + count < w ? z_row[u + count] : 0.0f;
                with_sides = z.data();
            }
            project_points({with_sides, z_up + u, z_down + u, u, count}, row,
                           projection.while_read(), limits, offsets.data(), values.data());
            const std::span landed(offsets.data(), static_cast<std::size_t>(count));
            keep_nearest(landed, values.data(), to);
        };
        tiles_.for_each_landing_run(v, [&](int begin, int end) {
            for (int u = begin; u < end; u += most)
                project(u, std::min(most, end - u));
        });
    }
}

void Warp::look_up_nodes(const DepthSurface &surface, int tile_row) {
    const ImageView<const float> z = surface.z();
    // What the nodes of the tile that is `ahead` tiles to the right will read is fetched into the
    // cache: about so many columns and rows of the surface.
    constexpr int ahead = 4, columns = TileMapping::tile_px, rows = columns - mapped_block_px;
    const auto last_u = static_cast<float>(z.width() - 1 - columns);
    const auto last_v = static_cast<float>(z.height() - 1 - rows);
    for (int x = 0; x < grid_.columns(); ++x) {
        if (const int next = x + ahead;
            next < grid_.columns() && tiles_.content(next, tile_row) == TileContent::mapped) {
            const MappedCorner &corner = tiles_.mapped(next, tile_row).corners[0];
            const int u = static_cast<int>(std::max(0.0f, std::min(corner.u, last_u)));
            const int v = static_cast<int>(std::max(0.0f, std::min(corner.v, last_v)) + 0.5f);
            // Not in a function of its own: g++ leaves out those that do nothing else.
            const float *row = z.row(v) + u;
            for (int i = 0; i <= rows; i += mapped_block_px, row += mapped_block_px * z.stride()) {
                hwy::Prefetch(row);
                hwy::Prefetch(row + columns);
            }
        }
        if (tiles_.content(x, tile_row) == TileContent::mapped)
            grid_.look_up(x, tile_row, tiles_.mapped(x, tile_row), z,
                          options_.least_edge_distance_px);
        else
            grid_.leave_out(x, tile_row);
    }
}

/// Tiles beside each other whose pixels share a cache line.
template <class Pixel>
constexpr int tiles_in_line = static_cast<int>(cache_line / (TileMapping::tile_px * sizeof(Pixel)));

/// The functions that draw tell how many pixels have depth.
int Warp::draw_tiles(const Drawing &to, int tile_row) {
    constexpr int size = TileMapping::tile_px;
    const int first = tile_row * size, end = std::min(first + size, to_.height);
    const int next_end = std::min(end + size, to_.height);
    const ImageView<const float> z = to.surface.z();
    int drawn = 0;
    int in_grid = 0; // tiles that are empty where nothing is drawn
    if (tile_row < grid_.rows()) {
        grid_.draw_even(tile_row, to.depth, to.edge_distance);
        in_grid = grid_.columns();
    }
    for (int x = 0; x < tiles_.columns(); ++x) {
        // Stores wait for what is not in the cache: the lines of the next row of tiles are fetched.
        if (x % tiles_in_line<std::uint16_t> == 0) {
            const std::uint16_t *line = to.depth.row(end) + x * size;
            for (int v = end; v < next_end; ++v, line += to.depth.stride())
                hwy::Prefetch(line);
        }
        if (x % tiles_in_line<std::uint8_t> == 0) {
            const std::uint8_t *line = to.edge_distance.row(end) + x * size;
            for (int v = end; v < next_end; ++v, line += to.edge_distance.stride())
                hwy::Prefetch(line);
        }
        const TileContent content = tiles_.content(x, tile_row);
        TileReadings &readings = readings_(x, tile_row);
        readings = {};
        if (content == TileContent::mapped) {
            drawn += grid_.draw_uneven(x, tile_row, tiles_.mapped(x, tile_row), z,
                                       options_.least_edge_distance_px, to.depth, to.edge_distance);
            readings = grid_.readings(x, tile_row);
        }
        if (content != TileContent::nothing)
            continue;
        readings = TileReadings::empty();
        if (x < in_grid)
            continue;
        const int left = x * size, width = std::min(size, to_.width - left);
        for (int v = first; v < end; ++v) {
            std::fill_n(to.depth.row(v) + left, width, std::uint16_t{0});
            std::fill_n(to.edge_distance.row(v) + left, width, std::uint8_t{0});
        }
    }
    for (int v = first; v < end; ++v)
        tiles_.for_each_mixed_run(
            v, [&](int begin, int end_column) { drawn += draw_mixed(to, v, begin, end_column); });
    return drawn;
}

int Warp::draw_mixed(const Drawing &to, int v, int begin, int end) const {
    constexpr int most = 64; // pixels at a time
    std::array<WarpedPixel, most> pixels;
    std::array<std::uint8_t, most> doubtful;
    const ImageView<const WarpedPixel> from = landed();
    int drawn = 0;
    const float y = static_cast<float>((v - to_.cy) / to_.fy);
    const auto relative = [&](int u) {
        return 1 / to.correction.scale(static_cast<float>((u - to_.cx) / to_.fx), y);
    };
    for (int first = begin; first < end; first += most) {
        const int count = std::min(most, end - first);
        const WarpedPixel *const in = from.row(v) + first;
        find_doubtful({from.row(v - 1) + first, in, from.row(v + 1) + first, count}, pixels.data(),
                      doubtful.data());
        const std::uint8_t *const marks_end = doubtful.data() + count;
        for (const std::uint8_t *mark = doubtful.data(); to.surface.options().crack_px > 0;) {
            mark = static_cast<const std::uint8_t *>(
                std::memchr(mark, 1, static_cast<std::size_t>(marks_end - mark)));
            if (!mark)
                break;
            const std::ptrdiff_t i = mark - doubtful.data();
            if (const WarpedPixel filled = fill_pixel(to.surface, in + i); filled != 0)
                pixels[static_cast<std::size_t>(i)] = filled;
            ++mark;
        }
        if (options_.edges_hide)
            for (int i = 0; i < count; ++i) {
                WarpedPixel &pixel = pixels[static_cast<std::size_t>(i)];
                pixel = (pixel & warped_edge_mask) < options_.least_edge_distance_px ? 0 : pixel;
            }
        // Within so few pixels the correction is linear.
        const float left = relative(first), right = relative(first + most);
        drawn += find_readings({pixels.data(), count, left, (right - left) / most},
                               to.depth.row(v) + first, to.edge_distance.row(v) + first);
    }
    return drawn;
}

/// What the pixel at `at` of the scattered map becomes if it is a crack: an empty pixel, or one
/// through which a far surface shows, between two pixels of one surface on opposite sides; 0 if it
/// is none.
WarpedPixel Warp::fill_pixel(const DepthSurface &surface, const WarpedPixel *at) const {
    const bool empty = *at == nothing_landed;
    float sum = 0;
    int pairs = 0, edge = warped_edge_mask;
    bool beside = false; // it lies on the surface itself
    for_each_pair_across(
        landed().stride(), surface.options().crack_px,
        [&](std::ptrdiff_t offset) { return at[offset] != nothing_landed; },
        [&](std::ptrdiff_t before, std::ptrdiff_t after, float share) {
            const WarpedPixel a = at[before], b = at[after];
            const float za = warped_z(a), zb = warped_z(b);
            const float limit = surface.edge_step(std::min(za, zb));
            if (std::abs(za - zb) > limit)
                return;
            beside = beside || (!empty && warped_z(*at) < std::max(za, zb) + limit);
            sum += za + share * (zb - za);
            ++pairs;
            edge = std::min({edge, a & warped_edge_mask, b & warped_edge_mask});
        });
    if (beside)
        return 0;
    if (pairs < (empty ? 1 : 3))
        return 0;
    const float z = sum / static_cast<float>(pairs);
    return (static_cast<WarpedPixel>(z * warped_units_per_m + 0.5f) << warped_depth_shift) | edge;
}

} // namespace afterglow
