// SPDX-License-Identifier: Apache-2.0
#include "tools/picture/error_colors.hpp"

#include "tools/picture/depth_colors.hpp"

#include <cmath>

namespace afterglow {
namespace {

constexpr Rgb nothing{8, 8, 10};

} // namespace

Rgb error_color(double percent) {
    constexpr Rgb stops[] = {
        {24, 28, 52}, {86, 36, 98}, {190, 60, 72}, {244, 140, 54}, {252, 232, 160}};
    return interpolate(stops, percent / largest_error_shown);
}

Image<Rgb> color_error(DepthView estimate, DepthView truth) {
    Image<Rgb> picture(truth.width(), truth.height(), nothing);
    for (int v = 0; v < truth.height(); ++v)
        for (int u = 0; u < truth.width(); ++u)
            if (estimate(u, v) != 0 && truth(u, v) != 0)
                picture(u, v) = error_color(
                    100 * std::abs(1.0 - static_cast<double>(estimate(u, v)) / truth(u, v)));
    return picture;
}

} // namespace afterglow
