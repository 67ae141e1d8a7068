// SPDX-License-Identifier: Apache-2.0
#include "eval/datasets/netpbm.hpp"

#include "core/base/read_file.hpp"
#include "drivers/files/image_file.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cerrno>
#include <charconv>
#include <string_view>

namespace afterglow {
namespace {

struct Netpbm {
    int width = 0;
    int height = 0;
    std::string_view pixels; ///< exactly those that the header promises
};

bool is_space(char c) {
    return c == ' ' || c == '\t' || c == '\n' || c == '\r';
}

/// Takes the next number of a header, past white space and comments; -1 where there is none.
int take_number(std::string_view &text) {
    while (!text.empty() && (is_space(text.front()) || text.front() == '#'))
        text.remove_prefix(text.front() == '#' ? std::min(text.find('\n'), text.size()) : 1);
    int number = -1;
    const auto end = std::from_chars(text.data(), text.data() + text.size(), number).ptr;
    text.remove_prefix(static_cast<std::size_t>(end - text.data()));
    return number;
}

Result<Netpbm> parse(const std::string &path, std::string_view text, std::string_view magic,
                     int highest, std::size_t bytes_per_pixel) {
    const auto error = [&](const std::string &what) {
        return Error{fmt::format("{}: {}", path, what), EINVAL};
    };
    if (!text.starts_with(magic))
        return error(fmt::format("is not a Netpbm file of kind {}", magic));
    text.remove_prefix(magic.size());
    Netpbm image;
    image.width = take_number(text);
    image.height = take_number(text);
    const int maxval = take_number(text);
    if (image.width < 1 || image.height < 1 || image.width > max_image_side ||
        image.height > max_image_side)
        return error(
            fmt::format("its header has no size of 1 to {} pixels a side", max_image_side));
    if (maxval != highest)
        return error(fmt::format("its highest value is {} instead of {}", maxval, highest));
    if (text.empty() || !is_space(text.front()))
        return error("is cut short in its header");
    text.remove_prefix(1);
    const std::size_t size = static_cast<std::size_t>(image.width) *
                             static_cast<std::size_t>(image.height) * bytes_per_pixel;
    if (text.size() < size)
        return error(
            fmt::format("is cut short: {} bytes of pixels instead of {}", text.size(), size));
    image.pixels = text.substr(0, size);
    return image;
}

} // namespace

Result<Luma> read_ppm_luma(const std::string &path) {
    const Result<std::string> file = read_file(path);
    if (!file)
        return file.error();
    const Result<Netpbm> ppm = parse(path, *file, "P6", 255, 3);
    if (!ppm)
        return ppm.error();
    Luma luma(ppm->width, ppm->height);
    std::size_t at = 0;
    const auto next = [&] { return static_cast<unsigned char>(ppm->pixels[at++]); };
    for (std::uint8_t &pixel : luma.pixels()) {
        Rgb color;
        for (std::uint8_t *part : {&color.red, &color.green, &color.blue})
            *part = next();
        pixel = luma_of(color);
    }
    return luma;
}

Result<Image<std::uint16_t>> read_pgm16(const std::string &path, std::endian order) {
    const Result<std::string> file = read_file(path);
    if (!file)
        return file.error();
    const Result<Netpbm> pgm = parse(path, *file, "P5", 65535, 2);
    if (!pgm)
        return pgm.error();
    Image<std::uint16_t> image(pgm->width, pgm->height);
    std::size_t at = 0;
    const auto next = [&] { return static_cast<unsigned char>(pgm->pixels[at++]); };
    for (std::uint16_t &pixel : image.pixels()) {
        const unsigned first = next(), second = next();
        pixel = static_cast<std::uint16_t>(order == std::endian::big ? first << 8 | second
                                                                     : second << 8 | first);
    }
    return image;
}

} // namespace afterglow
