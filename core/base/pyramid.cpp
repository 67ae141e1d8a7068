// SPDX-License-Identifier: Apache-2.0
#include "core/base/pyramid.hpp"

namespace afterglow {
namespace {

template <class T>
void halve(ImageView<const T> from, ImageView<float> to) {
    for (int v = 0; v < to.height(); ++v) {
        const T *a = from.row(2 * v);
        const T *b = from.row(2 * v + 1);
        float *out = to.row(v);
        for (int u = 0; u < to.width(); ++u)
            out[u] = 0.25f * static_cast<float>(a[2 * u] + a[2 * u + 1] + b[2 * u] + b[2 * u + 1]);
    }
}

} // namespace

Pyramid::Pyramid(int width, int height, int levels) {
    for (int l = 1; l <= levels; ++l)
        levels_.emplace_back(width >> l, height >> l);
}

void Pyramid::build(LumaView image) {
    halve<std::uint8_t>(image, levels_[0]);
    for (std::size_t l = 1; l < levels_.size(); ++l)
        halve<float>(levels_[l - 1].view(), levels_[l]);
}

} // namespace afterglow
