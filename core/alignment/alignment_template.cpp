// SPDX-License-Identifier: Apache-2.0
#include "core/alignment/alignment_template.hpp"

#include "core/alignment/template_kernels.hpp"

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstdint>
#include <hwy/cache_control.h>
#include <span>

namespace afterglow {
namespace {

/// Gradients of a well-exposed image: root mean square of the points' gradients, grey values per
/// pixel.
constexpr float full_gradient = 27;
/// Below it, rounding to whole grey values changes an image more than its noise does.
constexpr float least_contrast = 0.15f;

/// TemplatePoints::contrast of the finest level, from its points.
float contrast_of(const FoundPoints &found, int count) {
    float squares = 0;
    for (std::size_t i = 0; i < static_cast<std::size_t>(count); ++i)
        squares +=
            found.gradient_u[i] * found.gradient_u[i] + found.gradient_v[i] * found.gradient_v[i];
    const float gradient = std::sqrt(squares / static_cast<float>(std::max(count, 1)));
    return std::clamp(gradient / full_gradient, least_contrast, 1.0f);
}

/// Depth of pixel (u, v) of a level: mean of four readings that it covers if they lie on one
/// surface and away from depth edges, 0 otherwise. Two of them may be missing.
float level_depth(const DepthSurface &surface, int level, int u, int v) {
    const int n = 1 << level, step = n / 2;
    const ImageView<const float> depths = surface.z();
    const ImageView<const std::uint8_t> edges = surface.edge_distance();
    const int x = u * n, y = v * n;
    const float *const z = depths.row(y) + x, *const z_below = depths.row(y + step) + x;
    const std::uint8_t *const edge = edges.row(y) + x, *const edge_below = edges.row(y + step) + x;
    if (std::min(std::min(edge[0], edge[step]), std::min(edge_below[0], edge_below[step])) <= 2)
        return 0;
    float sum = 0, low = 1e9f, high = 0;
    int count = 0;
    for (const float reading : {z[0], z[step], z_below[0], z_below[step]}) {
        sum += reading;
        low = reading != 0.0f && reading < low ? reading : low;
        high = reading > high ? reading : high;
        count += reading != 0.0f;
    }
    if (count < 2 || high - low > surface.edge_step(low) * (1.0f + 0.25f * static_cast<float>(n)))
        return 0;
    return sum / static_cast<float>(count);
}

/// Half the difference of two grey values.
float half_difference(Grey a, Grey b) {
    return 0.5f * grey_step * static_cast<float>(a - b);
}

/// A number that is greater for a steeper point, and of points that are alike for the upper one.
std::uint64_t in_order(float steepness, int row) {
    const auto bits = static_cast<std::uint64_t>(std::bit_cast<std::uint32_t>(steepness));
    return bits << 32 | static_cast<std::uint32_t>(~row);
}

/// The square cells that an image is parted into, as small as may be.
struct Cells {
    Cells(int width, int height, int most) {
        while (across(width) * across(height) > most)
            ++size;
    }
    int across(int pixels) const { return (pixels + size - 1) / size; }

    int size = 1;
};

} // namespace

TemplatePoints::TemplatePoints(int capacity) {
    const int rows = (capacity + block - 1) / block * block;
    for (AlignedVector<float> *column : {&x, &y, &z, &intensity, &row, &per_s})
        column->resize(static_cast<std::size_t>(rows));
    J = Image<float>(rows, derivatives);
}

AlignmentTemplate::AlignmentTemplate(const Intrinsics &camera, const TemplateOptions &options)
    : options_(options), steepness_(static_cast<std::size_t>(camera.width)),
      steepest_row_(steepness_.size()), steepest_(steepness_.size()) {
    for (int l = 0; l <= options.coarsest_level; ++l) {
        cameras_.push_back(camera.at_level(l));
        const int w = cameras_.back().width, h = cameras_.back().height;
        const Cells cells(w, h, options.points_per_level);
        levels_.emplace_back(l >= options.finest_level ? cells.across(w) * cells.across(h) : 0);
        const std::size_t points = levels_.back().x.size();
        for (AlignedVector<float> *column :
             {&found_.u, &found_.v, &found_.gradient_u, &found_.gradient_v})
            column->resize(std::max(column->size(), points));
    }
}

void AlignmentTemplate::build(const Pyramid &image, const DepthSurface &surface) {
    float coarser_contrast = 1;
    for (int l = options_.coarsest_level; l >= options_.finest_level; --l) {
        TemplatePoints &points = levels_[l];
        const bool finest = l == options_.finest_level;
        find_level(l, image.level(l), surface, finest ? coarser_contrast : 1);
        const float contrast = contrast_of(found_, points.count);
        points.contrast = finest ? contrast : 1;
        complete_points(found_, cameras_[l], options_, points);
        coarser_contrast = contrast;
    }
}

/// Of each cell in a row of cells the pixel with the steepest gradient, if it is steeper than
/// `weakest`; of several the upper one, and then the left one. `first_row`: the cells', at least 1.
std::span<const AlignmentTemplate::Pixel>
AlignmentTemplate::steepest_of_cells(GreyView image, int first_row, int cell, float weakest) {
    const int w = image.width();
    find_steepest(image, first_row, std::min(first_row + cell, image.height() - 1), steepness_,
                  steepest_row_);
    std::size_t found = 0;
    for (int u0 = 1; u0 < w - 1; u0 += cell) {
        // No branch depends on grey values: it could not be predicted.
        std::uint64_t most = in_order(weakest * weakest, 0); // above all that are as steep
        int best_u = 0;
        for (int u = u0; u < std::min(u0 + cell, w - 1); ++u) {
            const auto column = static_cast<std::size_t>(u);
            const std::uint64_t here = in_order(steepness_[column], steepest_row_[column]);
            best_u = here > most ? u : best_u;
            most = std::max(most, here);
        }
        if (best_u > 0)
            steepest_[found++] = {best_u, steepest_row_[static_cast<std::size_t>(best_u)]};
    }
    return std::span(steepest_).first(found);
}

// The pixel with the steepest gradient in each cell becomes a point, unless the gradient is noise.
// `contrast`: multiplies the noise; the level's own is known only when its points are found.
void AlignmentTemplate::find_level(int level, GreyView image, const DepthSurface &surface,
                                   float contrast) {
    TemplatePoints &points = levels_[level];
    const int cell = Cells(image.width(), image.height(), options_.points_per_level).size;
    // A central difference halves the noise variance; halving the image halves its deviation.
    const float weakest =
        2.0f * contrast * options_.pixel_noise / static_cast<float>(1 << std::min(level, 2));
    const ImageView<const float> depths = surface.z();
    const ImageView<const std::uint8_t> edges = surface.edge_distance();
    const int half = (1 << level) / 2;
    points.count = 0;
    for (int v0 = 1; v0 < image.height() - 1; v0 += cell) {
        const std::span<const Pixel> steepest = steepest_of_cells(image, v0, cell, weakest);
        for (const auto [u, v] : steepest) { // what level_depth() will read
            const float *const z = depths.row(v << level) + (u << level);
            const std::uint8_t *const edge = edges.row(v << level) + (u << level);
            hwy::Prefetch(z);
            hwy::Prefetch(z + half * depths.stride());
            hwy::Prefetch(edge);
            hwy::Prefetch(edge + half * edges.stride());
        }
        for (const auto [u, v] : steepest) {
            const float z = level_depth(surface, level, u, v);
            if (z == 0.0f)
                continue;
            const auto i = static_cast<std::size_t>(points.count++);
            found_.u[i] = static_cast<float>(u);
            found_.v[i] = static_cast<float>(v);
            found_.gradient_u[i] = half_difference(image(u + 1, v), image(u - 1, v));
            found_.gradient_v[i] = half_difference(image(u, v + 1), image(u, v - 1));
            points.z[i] = z;
            points.intensity[i] = grey_step * static_cast<float>(image(u, v));
        }
    }
}

} // namespace afterglow
