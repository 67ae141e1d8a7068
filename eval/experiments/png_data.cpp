// SPDX-License-Identifier: Apache-2.0
#include "eval/experiments/png_data.hpp"

#include "drivers/files/png_file.hpp"

#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <vector>

namespace afterglow {
namespace {

constexpr int most_width = 320;

/// Every so many pixels, so that depth is not averaged across edges.
Image<Rgb> thinned(const Image<Rgb> &picture) {
    const int step = (picture.width() + most_width - 1) / most_width;
    if (step <= 1)
        return picture;
    Image<Rgb> small(picture.width() / step, picture.height() / step);
    for (int v = 0; v < small.height(); ++v)
        for (int u = 0; u < small.width(); ++u)
            small(u, v) = picture(u * step, v * step);
    return small;
}

} // namespace

Picture depth_picture(const std::string &group, const std::string &caption, DepthView depth,
                      const DepthRange &range) {
    return {.group = group,
            .caption = caption,
            .png = png_data(color_depth(depth, range)),
            .colors = Picture::Colors::depth,
            .from = range.near_mm / 1000,
            .to = range.far_mm / 1000};
}

std::string base64(std::string_view bytes) {
    constexpr char digits[] = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
    std::string out;
    for (std::size_t i = 0; i < bytes.size(); i += 3) {
        std::uint32_t group = 0;
        for (std::size_t k = 0; k < 3; ++k)
            group =
                group << 8 | (i + k < bytes.size() ? static_cast<std::uint8_t>(bytes[i + k]) : 0);
        for (std::size_t k = 0; k < 4; ++k)
            out += i + k <= bytes.size() ? digits[group >> (18 - 6 * k) & 63] : '=';
    }
    return out;
}

std::string png_data(const Image<Rgb> &picture) {
    const Image<Rgb> small = thinned(picture);
    std::vector<const std::uint8_t *> rows;
    for (int v = 0; v < small.height(); ++v)
        rows.push_back(reinterpret_cast<const std::uint8_t *>(small.row(v)));
    char *bytes = nullptr;
    std::size_t size = 0;
    std::FILE *memory = ::open_memstream(&bytes, &size);
    if (!memory)
        return {};
    const Status encoded = encode_png(memory, {small.width(), small.height(), 8, false}, rows);
    std::fclose(memory);
    const std::string data = encoded ? base64({bytes, size}) : "";
    std::free(bytes);
    return data.empty() ? "" : "data:image/png;base64," + data;
}

} // namespace afterglow
