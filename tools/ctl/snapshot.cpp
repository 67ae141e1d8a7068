// SPDX-License-Identifier: Apache-2.0
#include "core/base/rgb.hpp"
#include "drivers/files/image_file.hpp"
#include "tools/ctl/commands.hpp"
#include "tools/ctl/stream.hpp"
#include "tools/picture/depth_colors.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cstdint>

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
Status take(Stream &stream, Shot &shot) {
    const afterglow_buffer buffers[] = {
        {AFTERGLOW_PLANE_LUMA, shot.luma.pixels().data(), shot.luma.pixels().size_bytes()},
        {AFTERGLOW_PLANE_DEPTH, shot.depth.pixels().data(), shot.depth.pixels().size_bytes()},
    };
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

/// The image on the left, depth in colours on the right.
Image<Rgb> draw(const Shot &shot) {
    const int width = shot.luma.width();
    const Image<Rgb> colors = color_depth(shot.depth, depth_range(shot.depth));
    Image<Rgb> picture(2 * width + gap_px, shot.luma.height(), Rgb{255, 255, 255});
    for (int v = 0; v < picture.height(); ++v) {
        std::transform(shot.luma.row(v), shot.luma.row(v) + width, picture.row(v),
                       [](std::uint8_t grey) {
                           return Rgb{grey, grey, grey};
                       });
        std::copy_n(colors.row(v), width, picture.row(v) + width + gap_px);
    }
    return picture;
}

} // namespace

Status snapshot(const std::string &bus, const std::string &path) {
    Result<Stream> stream = Stream::open(bus);
    if (!stream)
        return stream.error();
    const afterglow_stream_info info = stream->info();
    const auto width = static_cast<int>(info.width);
    const auto height = static_cast<int>(info.height);
    Shot shot{Luma(width, height), DepthMap(width, height), {}};
    if (const Status taken = take(*stream, shot); !taken)
        return taken.error();
    if (const Status written = write_png(path, draw(shot)); !written)
        return written.error();
    fmt::print("{}: frame {}, {}\n", path, shot.frame.index,
               shot.frame.source == AFTERGLOW_MEASURED ? "measured"
               : shot.frame.source == AFTERGLOW_ESTIMATED
                   ? fmt::format("estimated from {} frames earlier", shot.frame.age_frames)
                   : "without depth");
    return ok();
}

} // namespace afterglow
