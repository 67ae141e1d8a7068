// SPDX-License-Identifier: Apache-2.0
#include "core/keyframe/warp.hpp"

#include "core/keyframe/warp_kernels.hpp"

#include <algorithm>
#include <array>
#include <atomic>
#include <cmath>
#include <cstring>
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

/// While other threads do the same.
void keep_nearest_shared(std::span<const int> offsets, const WarpedPixel *values, WarpedPixel *to) {
    for (const int offset : offsets) {
        const WarpedPixel value = *values++;
        std::atomic_ref<WarpedPixel> pixel(to[offset]);
        WarpedPixel old = pixel.load(std::memory_order_relaxed);
        while (value < old && !pixel.compare_exchange_weak(old, value, std::memory_order_relaxed)) {
        }
    }
}

RowMotion row_motion(const Intrinsics &camera, const Twist &motion) {
    const Eigen::Matrix3d K = camera.matrix();
    const Eigen::Vector3d w = motion.tail<3>();
    Eigen::Matrix3d cross;
    cross << 0, -w.z(), w.y(), w.z(), 0, -w.x(), -w.y(), w.x(), 0;
    return {(K * cross * K.inverse()).cast<float>(), (K * motion.head<3>()).cast<float>(),
            static_cast<float>((camera.height - 1) / 2.0), 1 / static_cast<float>(camera.height),
            !motion.isZero(0)};
}

} // namespace

Warp::Warp(const Intrinsics &from, const Intrinsics &to, const WarpOptions &options)
    : from_(from), to_(to), options_(options), open_(to.width, to.height),
      nearest_(to.width + 2 * margin(), to.height + 2 * margin()), filled_(to.width, to.height),
      doubtful_(to.width, to.height),
      landing_((from.width + DepthSurface::tile_width - 1) / DepthSurface::tile_width,
               (from.height + DepthSurface::tile_height - 1) / DepthSurface::tile_height) {}

ImageView<const WarpedPixel> Warp::landed() const {
    return {nearest_.row(margin()) + margin(), to_.width, to_.height, nearest_.width()};
}

void Warp::run(const DepthSurface &surface, const Pose &pose, DepthView taken, WorkerPool &pool,
               const RollingShutter &shutter) {
    open_.find(taken);
    std::ranges::fill(nearest_.pixels(), nothing_landed);
    const int rows = to_.height, tile_rows = landing_.height(), n = pool.size();
    pool.run([&](int worker) {
        scatter(surface, pose, shutter, tile_rows * worker / n, tile_rows * (worker + 1) / n,
                n == 1);
    });
    pool.run([&](int worker) {
        for (int v = rows * worker / n; v < rows * (worker + 1) / n; ++v)
            open_.for_each_run(
                v, [&](int begin, int end) { fill_cracks(surface, taken, v, begin, end); });
    });
}

/// Whether points of a tile may land, or be the side of a crack, where there is room: the picture
/// of a box before the camera lies between those of its corners.
bool Warp::may_land(const DepthSurface &surface, int tile_x, int tile_y, const Pose &pose,
                    double margin_px) const {
    const TileDepths range = surface.tiles()(tile_x, tile_y);
    if (range.farthest == 0.0f)
        return false;
    Eigen::AlignedBox2d box;
    for (int corner = 0; corner < 8; ++corner) {
        const int u = (tile_x + (corner & 1)) * DepthSurface::tile_width;
        const int v = (tile_y + (corner >> 1 & 1)) * DepthSurface::tile_height;
        const Eigen::Vector3d X =
            pose * from_.back_project(u, v, corner & 4 ? range.farthest : range.nearest);
        if (!(X.z() > 0.01))
            return true;
        box.extend(to_.project(X));
    }
    const Eigen::Vector2f low = (box.min().array() - margin_px).cast<float>();
    const Eigen::Vector2f high = (box.max().array() + margin_px).cast<float>();
    return open_.any(low.x(), low.y(), high.x(), high.y());
}

void Warp::scatter(const DepthSurface &surface, const Pose &pose, const RollingShutter &shutter,
                   int first_tile_row, int end_tile_row, bool alone) {
    constexpr int strip = DepthSurface::tile_width;
    const int w = from_.width, h = from_.height;
    const Eigen::Matrix3d K = to_.matrix(), KR = K * pose.R, Ki = from_.matrix().inverse();
    const LandingLimits limits = {surface.options().nearest_m,
                                  surface.options().farthest_m,
                                  static_cast<float>(to_.width),
                                  static_cast<float>(to_.height),
                                  options_.edges_hide ? 1 : options_.least_edge_distance_px,
                                  options_.edges_hide ? options_.least_edge_distance_px : 0,
                                  nearest_.width()};
    const Eigen::Vector3d skew = shutter.skew.cast<double>();
    const double margin_px =
        options_.crack_px + 1 +
        to_.fx * (skew.norm() + shutter.motion.head<3>().norm() / surface.options().nearest_m +
                  shutter.motion.tail<3>().norm());
    const RowMotion motion = row_motion(to_, shutter.motion);
    for (int y = first_tile_row; y < end_tile_row; ++y)
        for (int x = 0; x < landing_.width(); ++x)
            landing_(x, y) = may_land(surface, x, y, pose, margin_px);

    WarpedPixel *const to = nearest_.row(margin()) + margin();
    std::array<float, strip + 2> z;
    std::array<int, strip> offsets;
    std::array<WarpedPixel, strip> values;
    const int end_row = std::min(end_tile_row * DepthSurface::tile_height, h);
    for (int v = first_tile_row * DepthSurface::tile_height; v < end_row; ++v) {
        const Eigen::Vector3d turn = skew * (static_cast<double>(v) / h - 0.5);
        const Eigen::Matrix3f A = (KR * rotation(turn) * Ki).cast<float>();
        const RowProjection row = {A.col(0), A.col(1) * static_cast<float>(v) + A.col(2),
                                   (K * pose.T).cast<float>()};
        const float *z_row = surface.z().row(v);
        const float *z_up = surface.z().row(std::max(v - 1, 0));
        const float *z_down = surface.z().row(std::min(v + 1, h - 1));
        const std::uint8_t *edge = surface.edge_distance().row(v);
        const std::uint8_t *landing = landing_.row(v / DepthSurface::tile_height);
        for (int u = 0; u < w; u += strip) {
            if (!landing[u / strip])
                continue;
            const int count = std::min(strip, w - u);
            // Beyond the picture there is no depth.
            z.front() = u > 0 ? z_row[u - 1] : 0.0f;
            std::copy_n(z_row + u, count, z.begin() + 1);
            z[static_cast<std::size_t>(count) + 1] = u + count < w ? z_row[u + count] : 0.0f;
            project_points({z.data(), z_up + u, z_down + u, edge + u, u, count}, row, motion,
                           limits, offsets.data(), values.data());
            const std::span landed(offsets.data(), static_cast<std::size_t>(count));
            (alone ? keep_nearest : keep_nearest_shared)(landed, values.data(), to);
        }
    }
}

void Warp::fill_cracks(const DepthSurface &surface, DepthView taken, int v, int begin, int end) {
    const ImageView<const WarpedPixel> from = landed();
    const WarpedPixel *in = from.row(v);
    WarpedPixel *out = filled_.row(v);
    std::uint8_t *doubtful = doubtful_.row(v);
    find_doubtful({from.row(v - 1) + begin, in + begin, from.row(v + 1) + begin, end - begin},
                  taken.row(v) + begin, out + begin, doubtful + begin);
    const auto next_doubtful = [&](int u) {
        const void *at = std::memchr(doubtful + u, 1, static_cast<std::size_t>(end - u));
        return at ? static_cast<int>(static_cast<const std::uint8_t *>(at) - doubtful) : end;
    };
    for (int u = next_doubtful(begin); u < end; u = next_doubtful(u + 1))
        if (const WarpedPixel filled = fill_pixel(surface, in + u); filled != 0)
            out[u] = filled;
    if (options_.edges_hide)
        for (int u = begin; u < end; ++u)
            out[u] = (out[u] & warped_edge_mask) < options_.least_edge_distance_px ? 0 : out[u];
}

/// What the pixel at `at` of the scattered map becomes if it is a crack: an empty pixel, or one
/// through which a far surface shows, between two pixels of one surface on opposite sides; 0 if it
/// is none.
WarpedPixel Warp::fill_pixel(const DepthSurface &surface, const WarpedPixel *at) const {
    const std::ptrdiff_t stride = nearest_.width();
    const int reach = options_.crack_px;
    const bool empty = *at == nothing_landed;
    float sum = 0;
    int pairs = 0, edge = warped_edge_mask;
    for (const std::ptrdiff_t step : {std::ptrdiff_t{1}, stride, stride + 1, 1 - stride}) {
        // The next pixels on both sides on which something landed, and how far they are.
        const int before = at[-step] == nothing_landed && reach > 1 ? 2 : 1;
        const int after = at[step] == nothing_landed && reach > 1 ? 2 : 1;
        const WarpedPixel a = at[-before * step], b = at[after * step];
        if (a == nothing_landed || b == nothing_landed || before + after > reach + 1)
            continue;
        const float za = warped_z(a), zb = warped_z(b);
        const float limit = surface.edge_step(std::min(za, zb));
        if (std::abs(za - zb) > limit)
            continue;
        if (!empty && warped_z(*at) < std::max(za, zb) + limit)
            return 0; // it lies on the surface itself
        const float t = static_cast<float>(before) / static_cast<float>(before + after);
        sum += za + t * (zb - za);
        ++pairs;
        edge = std::min({edge, a & warped_edge_mask, b & warped_edge_mask});
    }
    if (pairs < (empty ? 1 : 3))
        return 0;
    const float z = sum / static_cast<float>(pairs);
    return (static_cast<WarpedPixel>(z * warped_units_per_m + 0.5f) << warped_depth_shift) |
           warped_crack | edge;
}

} // namespace afterglow
