// SPDX-License-Identifier: Apache-2.0
#include "core/base/printable.hpp"
#include "core/base/rgb.hpp"
#include "drivers/files/image_file.hpp"
#include "drivers/files/png_file.hpp"
#include "tools/ctl/commands.hpp"
#include "tools/ctl/stream.hpp"
#include "tools/picture/depth_scale.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cerrno>
#include <cstdint>
#include <cstdio>
#include <cstring>
#include <fstream>
#include <span>
#include <unistd.h>
#include <vector>

namespace afterglow {
namespace {

constexpr int gap_px = 8;
constexpr int frames_to_try = 90;

struct Shot {
    Luma luma;
    DepthMap depth;
    afterglow_frame frame = {};
};

/// The first frame with depth, or the last without when none comes.
Status take(Stream &stream, bool with_image, Shot &shot) {
    const afterglow_buffer all[] = {
        {AFTERGLOW_PLANE_DEPTH, 0, shot.depth.pixels().data(), shot.depth.pixels().size_bytes()},
        {AFTERGLOW_PLANE_LUMA, 0, shot.luma.pixels().data(), shot.luma.pixels().size_bytes()},
    };
    const auto buffers = std::span(all).first(with_image ? 2 : 1);
    for (int tried = 0; tried < frames_to_try; ++tried) {
        const Result<afterglow_frame> frame = stream.next(buffers);
        if (!frame)
            return frame.error();
        shot.frame = *frame;
        if (frame->source != AFTERGLOW_NONE)
            break;
    }
    return ok();
}

/// The image on the left, its depth in colours, and the scale of the colours on the right.
Image<Rgb> draw(const Shot &shot) {
    const int width = shot.luma.width();
    const int height = shot.luma.height();
    const DepthRange range = depth_range(shot.depth);
    const Image<Rgb> colors = color_depth(shot.depth, range);
    const Image<Rgb> scale = depth_scale(range, height);
    Image<Rgb> picture(2 * (width + gap_px) + scale.width(), height, Rgb{255, 255, 255});
    for (int v = 0; v < height; ++v) {
        Rgb *row = picture.row(v);
        std::transform(shot.luma.row(v), shot.luma.row(v) + width, row, [](std::uint8_t grey) {
            return Rgb{grey, grey, grey};
        });
        std::copy_n(colors.row(v), width, row + width + gap_px);
        std::copy_n(scale.row(v), scale.width(), row + 2 * (width + gap_px));
    }
    return picture;
}

/// 16-bit PGM, whose numbers are big-endian.
Status write_pgm(const std::string &path, DepthView depth) {
    std::ofstream file(path, std::ios::binary | std::ios::trunc);
    file << "P5\n" << depth.width() << ' ' << depth.height() << "\n65535\n";
    for (int v = 0; v < depth.height(); ++v)
        for (int u = 0; u < depth.width(); ++u)
            file.put(static_cast<char>(depth(u, v) >> 8)).put(static_cast<char>(depth(u, v)));
    file.close();
    if (!file)
        return Error{fmt::format("{} cannot be written: {}", printable(path), std::strerror(errno)),
                     errno};
    return ok();
}

Status write_to_stdout(const Image<Rgb> &picture) {
    std::vector<const std::uint8_t *> rows;
    for (int v = 0; v < picture.height(); ++v)
        rows.push_back(reinterpret_cast<const std::uint8_t *>(picture.row(v)));
    return encode_png(stdout, {picture.width(), picture.height(), 8, false}, rows);
}

} // namespace

Status snapshot(const std::string &bus, const std::string &path) {
    const bool to_stdout = path == "-";
    const bool is_pgm = path.ends_with(".pgm");
    if (!to_stdout && !is_pgm && !path.ends_with(".png"))
        return Error{fmt::format("{}: the extension says what is written: .png (image and depth in "
                                 "colours), .pgm (depth in millimetres, 16 bits), or - (PNG to "
                                 "standard output)",
                                 printable(path)),
                     EINVAL};
    if (to_stdout && ::isatty(STDOUT_FILENO) == 1)
        return Error{"a picture is not written to a terminal; redirect standard output", EINVAL};
    Result<Stream> stream = Stream::open(bus, !is_pgm);
    if (!stream)
        return stream.error();
    const afterglow_info info = stream->info();
    const auto width = static_cast<int>(info.width);
    const auto height = static_cast<int>(info.height);
    Shot shot{Luma(width, height), DepthMap(width, height), {}};
    if (const Status taken = take(*stream, !is_pgm, shot); !taken)
        return taken.error();
    const Status written = is_pgm      ? write_pgm(path, shot.depth)
                           : to_stdout ? write_to_stdout(draw(shot))
                                       : write_png(path, draw(shot));
    if (!written)
        return written.error();
    fmt::print(to_stdout ? stderr : stdout, "{}: frame {}, {}\n", printable(path), shot.frame.index,
               shot.frame.source == AFTERGLOW_MEASURED ? "measured"
               : shot.frame.source == AFTERGLOW_ESTIMATED
                   ? fmt::format("estimated from {} frames earlier", shot.frame.age_frames)
                   : "without depth");
    return ok();
}

} // namespace afterglow
