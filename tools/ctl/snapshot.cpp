// SPDX-License-Identifier: Apache-2.0
#include "core/base/printable.hpp"
#include "core/base/rgb.hpp"
#include "core/base/write_file.hpp"
#include "drivers/files/image_file.hpp"
#include "drivers/files/png_file.hpp"
#include "tools/ctl/command.hpp"
#include "tools/ctl/frame_json.hpp"
#include "tools/ctl/stream.hpp"
#include "tools/picture/depth_scale.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cerrno>
#include <cstdint>
#include <cstdio>
#include <memory>
#include <string>
#include <unistd.h>
#include <vector>

namespace afterglow {
namespace {

constexpr int gap_px = 8;
constexpr int frames_to_try = 90;

/// The picture with the image and its depth, or the depth alone.
enum class Format { png, pgm };

struct Shot {
    Luma luma;
    DepthMap depth;
    afterglow_frame frame = {};
};

/// The first frame with depth, or the last of some without when none comes. With the image for a
/// PNG.
Result<Shot> take(Stream &stream, Format format) {
    const auto [width, height] = stream.size(AFTERGLOW_PLANE_DEPTH);
    const auto [image_width, image_height] = stream.size(AFTERGLOW_PLANE_LUMA);
    Shot shot{Luma(image_width, image_height), DepthMap(width, height), {}};
    std::vector<afterglow_buffer> buffers = {
        {AFTERGLOW_PLANE_DEPTH, 0, shot.depth.pixels().data(), shot.depth.pixels().size_bytes()}};
    if (format == Format::png)
        buffers.push_back(
            {AFTERGLOW_PLANE_LUMA, 0, shot.luma.pixels().data(), shot.luma.pixels().size_bytes()});
    for (int tried = 0; tried < frames_to_try && shot.frame.source == AFTERGLOW_NONE; ++tried) {
        const Result<afterglow_frame> frame = stream.next(buffers);
        if (!frame)
            return frame.error();
        shot.frame = *frame;
    }
    return shot;
}

/// The image on the left, its depth in colours, and the scale of the colours on the right.
Image<Rgb> draw(const Shot &shot) {
    const int height = std::max(shot.luma.height(), shot.depth.height());
    const DepthRange range = depth_range(shot.depth);
    const Image<Rgb> colors = color_depth(shot.depth, range);
    const Image<Rgb> scale = depth_scale(range, height);
    const int colors_at = shot.luma.width() + gap_px;
    const int scale_at = colors_at + colors.width() + gap_px;
    Image<Rgb> picture(scale_at + scale.width(), height, Rgb{255, 255, 255});
    for (int v = 0; v < shot.luma.height(); ++v)
        std::transform(shot.luma.row(v), shot.luma.row(v) + shot.luma.width(), picture.row(v),
                       [](std::uint8_t grey) {
                           return Rgb{grey, grey, grey};
                       });
    for (int v = 0; v < colors.height(); ++v)
        std::copy_n(colors.row(v), colors.width(), picture.row(v) + colors_at);
    for (int v = 0; v < height; ++v)
        std::copy_n(scale.row(v), scale.width(), picture.row(v) + scale_at);
    return picture;
}

/// 16-bit PGM, whose numbers are big-endian.
Status write_pgm(const std::string &path, DepthView depth) {
    std::string bytes = fmt::format("P5\n{} {}\n65535\n", depth.width(), depth.height());
    for (int v = 0; v < depth.height(); ++v)
        for (int u = 0; u < depth.width(); ++u) {
            bytes += static_cast<char>(depth(u, v) >> 8);
            bytes += static_cast<char>(depth(u, v));
        }
    return write_file(path, bytes);
}

Status write_to_stdout(const Image<Rgb> &picture) {
    std::vector<const std::uint8_t *> rows;
    for (int v = 0; v < picture.height(); ++v)
        rows.push_back(reinterpret_cast<const std::uint8_t *>(picture.row(v)));
    const Status encoded = encode_png(stdout, {picture.width(), picture.height(), 8, false}, rows);
    return encoded ? encoded
                   : Error{"standard output " + encoded.error().message, encoded.error().code};
}

Status write(const std::string &path, Format format, const Shot &shot) {
    if (format == Format::pgm)
        return write_pgm(path, shot.depth);
    return path == "-" ? write_to_stdout(draw(shot)) : write_png(path, draw(shot));
}

Result<Format> format_of(const std::string &path) {
    if (path == "-" && ::isatty(STDOUT_FILENO) == 1)
        return Error{"a picture is not written to a terminal; redirect standard output", EINVAL};
    if (path == "-" || path.ends_with(".png"))
        return Format::png;
    if (path.ends_with(".pgm"))
        return Format::pgm;
    return Error{fmt::format("{}: the extension says what is written: .png (image and depth in "
                             "colours), .pgm (depth in millimetres, 16 bits), or - (PNG to "
                             "standard output)",
                             printable(path)),
                 EINVAL};
}

std::string describe(const afterglow_frame &frame) {
    return frame.source == AFTERGLOW_MEASURED ? "measured"
           : frame.source == AFTERGLOW_ESTIMATED
               ? fmt::format("estimated from {} frames earlier", frame.age_frames)
               : "without depth";
}

Result<int> snapshot(const Settings &settings, const std::string &path) {
    const Result<Format> format = format_of(path);
    if (!format)
        return format.error();
    Result<Stream> stream = Stream::open(
        settings.bus, *format == Format::png ? Stream::Planes::images : Stream::Planes::depth);
    if (!stream)
        return stream.error();
    const Result<Shot> shot = take(*stream, *format);
    if (!shot)
        return shot.error();
    if (const Status written = write(path, *format, *shot); !written)
        return written.error();
    std::FILE *told = path == "-" ? stderr : stdout; // there, the picture goes to stdout
    if (settings.json)
        fmt::print(told, "{}\n",
                   Json({{"path", path}, {"frame", to_json(shot->frame)}})
                       .dump(2, ' ', false, Json::error_handler_t::replace));
    else
        fmt::print(told, "{}: frame {}, {}\n", printable(path), shot->frame.index,
                   describe(shot->frame));
    return 0;
}

} // namespace

Action declare_snapshot(CLI::App &app, const Settings &settings) {
    const auto path = std::make_shared<std::string>();
    app.add_option("FILE", *path,
                   "NAME.png: image and depth in colours; NAME.pgm: depth in millimetres, 16 "
                   "bits; -: the PNG to stdout")
        ->type_name("")
        ->required()
        ->check([](const std::string &given) {
            const Result<Format> format = format_of(given);
            return format ? std::string() : format.error().message;
        });
    return [&settings, path] { return snapshot(settings, *path); };
}

} // namespace afterglow
