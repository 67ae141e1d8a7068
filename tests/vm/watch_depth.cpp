// SPDX-License-Identifier: Apache-2.0
// watch_depth BUS RECORDING FRAMES [DIR]: reads what a daemon publishes whose cameras play a
// recording, and holds it against that. A line for each frame:
//
//     NUMBER SOURCE ILLUMINATED T_NS MRE MEASUREMENT_T_NS
//
// NUMBER is its number in the recording, or -1: no image of it. MRE is the mean relative error of
// its depth, percent, over the pixels that it and the recording have; 0 where depth is not
// registered to the images. MEASUREMENT_T_NS is when its map was measured, if it is one.
//
// Ends and fails if an image is not one of the recording, or a measured map not that of its image;
// but where that has holes, they may be filled, and where depth is not registered nothing is said
// of maps. With DIR depth is written there as 000000.png and so on.
#include "afterglow/afterglow.h"
#include "drivers/files/image_file.hpp"
#include "drivers/files/recording.hpp"
#include "tests/open_stream.hpp"
#include "tests/vm/played_recording.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cstdio>
#include <cstdlib>
#include <string>
#include <vector>

namespace {

using namespace afterglow;

/// All images and maps of a recording.
struct RecordedFrames {
    explicit RecordedFrames(const Recording &recording) {
        for (std::size_t k = 0; k < recording.entries.size(); ++k) {
            images.emplace_back(recording.camera.width, recording.camera.height);
            maps.emplace_back(recording.tof().width, recording.tof().height);
            if (!read_luma(recording.entries[k].color_path, images.back()) ||
                !read_depth_mm(recording, k, maps.back()))
                std::exit(2);
        }
    }
    int number_of(const Luma &image) const {
        const auto at = std::find(images.begin(), images.end(), image);
        return at == images.end() ? -1 : static_cast<int>(at - images.begin());
    }

    std::vector<Luma> images;
    std::vector<DepthMap> maps;
};

struct Seen {
    afterglow_frame frame = empty_frame();
    Luma luma;
    DepthMap depth;
};

bool is_filled(const DepthMap &published, const DepthMap &map) {
    return std::equal(map.pixels().begin(), map.pixels().end(), published.pixels().begin(),
                      [](std::uint16_t own, std::uint16_t z) { return own == 0 || own == z; });
}

/// Percent.
double mean_relative_error(const DepthMap &published, const DepthMap &truth) {
    double sum = 0;
    int count = 0;
    for (std::size_t i = 0; i < truth.pixels().size(); ++i) {
        const int z = truth.pixels()[i];
        const int own = published.pixels()[i];
        if (z == 0 || own == 0)
            continue;
        sum += std::abs(own - z) / static_cast<double>(z);
        ++count;
    }
    return count == 0 ? 0 : 100 * sum / count;
}

/// The next frame, in order; false when there is none any more.
bool read_next(afterglow_stream *stream, bool first, Seen &seen) {
    const afterglow_buffer want[] = {
        {AFTERGLOW_PLANE_LUMA, 0, seen.luma.pixels().data(), seen.luma.pixels().size()},
        {AFTERGLOW_PLANE_DEPTH, 0, seen.depth.pixels().data(), 2 * seen.depth.pixels().size()}};
    for (;;) {
        const int read = first ? afterglow_read_latest(stream, &seen.frame, want, 2)
                               : afterglow_read(stream, seen.frame.index + 1, &seen.frame, want, 2);
        if (read == 0)
            return true;
        if (read != -EAGAIN || afterglow_wait(stream, 60'000) != 0)
            return false;
    }
}

int watch(const char *bus, const Recording &recording, int frames, const std::string &folder) {
    const RecordedFrames recorded(recording);
    afterglow_stream *stream = nullptr;
    const afterglow_options options = {.size = sizeof options,
                                       .flags = AFTERGLOW_IMAGES,
                                       .bus = bus,
                                       .timeout_ms = 0,
                                       .interval_ms = 0};
    if (const int error = afterglow_open(&options, &stream); error != 0) {
        fmt::print(stderr, "watch_depth: {}\n", afterglow_strerror(error));
        return 1;
    }
    Seen seen;
    seen.luma = Luma(recording.camera.width, recording.camera.height);
    afterglow_plane_info published = {};
    published.size = sizeof published;
    if (afterglow_get_plane_info(stream, AFTERGLOW_PLANE_DEPTH, &published) != 0)
        return 1;
    seen.depth = DepthMap(static_cast<int>(published.width), static_cast<int>(published.height));
    for (int count = 0; count < frames; ++count) {
        if (!read_next(stream, count == 0, seen)) {
            fmt::print("the stream has ended\n");
            return 1;
        }
        const int number = recorded.number_of(seen.luma);
        const bool measured = seen.frame.source == AFTERGLOW_MEASURED;
        const DepthMap *map = number < 0 || recording.rig
                                  ? nullptr
                                  : &recorded.maps[static_cast<std::size_t>(number)];
        fmt::print("{} {} {} {} {:.2f} {}\n", number, seen.frame.source,
                   seen.frame.emitter == AFTERGLOW_EMITTER_ON ? 1 : 0, seen.frame.t_ns,
                   map ? mean_relative_error(seen.depth, *map) : 0,
                   measured ? seen.frame.measurement_t_ns : 0);
        std::fflush(stdout);
        if (number < 0 || (map && measured && !is_filled(seen.depth, *map)))
            return 1;
        if (folder.empty())
            continue;
        if (!write_png(fmt::format("{}/{:06}.png", folder, count), seen.depth.view()))
            return 1;
    }
    afterglow_close(stream);
    return 0;
}

} // namespace

int main(int argc, char **argv) {
    if (argc != 4 && argc != 5) {
        std::fprintf(stderr, "usage: watch_depth BUS RECORDING FRAMES [DIR]\n");
        return 2;
    }
    const Result<Recording> recording = vm::open_played(argv[2]);
    return recording ? watch(argv[1], *recording, std::atoi(argv[3]), argc == 5 ? argv[4] : "") : 2;
}
