// SPDX-License-Identifier: Apache-2.0
#include "eval/datasets/scale.hpp"

#include <algorithm>
#include <cassert>
#include <cmath>
#include <vector>

namespace afterglow {
namespace {

/// Averages of `length` spans of `scale` elements each, the first beginning at `begin`: calls
/// sum(i, j, share) for each source element j that target element i covers, shares summing to 1.
template <class Sum>
void for_shares(double begin, double scale, int length, int last, Sum &&sum) {
    for (int i = 0; i < length; ++i) {
        const double from = begin + i * scale, to = from + scale;
        for (int j = static_cast<int>(from); j <= last && j < to; ++j)
            sum(i, j, (std::min(to, j + 1.0) - std::max(from, double(j))) / scale);
    }
}

} // namespace

Luma cropped_and_shrunk(LumaView image, int width, int height) {
    assert(image.width() >= width && image.height() >= height);
    const double scale = std::min(image.width() / double(width), image.height() / double(height));
    const double left = (image.width() - width * scale) / 2;
    const double top = (image.height() - height * scale) / 2;

    Image<float> narrow(width, image.height());
    for (int v = 0; v < image.height(); ++v)
        for_shares(left, scale, width, image.width() - 1, [&](int u, int from, double share) {
            narrow(u, v) += static_cast<float>(share) * image(from, v);
        });
    Image<float> small(width, height);
    for_shares(top, scale, height, image.height() - 1, [&](int v, int from, double share) {
        for (int u = 0; u < width; ++u)
            small(u, v) += static_cast<float>(share) * narrow(u, from);
    });
    Luma luma(width, height);
    std::transform(small.pixels().begin(), small.pixels().end(), luma.pixels().begin(),
                   [](float value) { return static_cast<std::uint8_t>(std::lround(value)); });
    return luma;
}

} // namespace afterglow
