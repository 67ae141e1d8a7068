// SPDX-License-Identifier: Apache-2.0
// record_room DIR FRAMES PERIOD_MS [WIDTH HEIGHT]: records the synthetic room, 160x120, as a
// recording.
// record_room DIR FRAMES PERIOD_MS rig: the same as two cameras see it that differ in size, lens
// and place: images of 1280x720 and, as measured, depth of 320x240. From image to image they move
// as far as a hand-held camera does at 30 images a second.
#include "drivers/files/write_recording.hpp"
#include "drivers/simulated/synthetic/truth.hpp"
#include "eval/rigs/rig_sweep.hpp"
#include "tests/record_rig.hpp"

#include <cstdio>
#include <cstdlib>
#include <cstring>

namespace {

using namespace afterglow;

std::int64_t time_ns(std::uint64_t frame, int period_ms) {
    return static_cast<std::int64_t>(frame) * period_ms * 1'000'000;
}

Status record_registered(const SyntheticOptions &options, const char *folder, int period_ms) {
    SyntheticTruth truth(options);
    Result<RecordingWriter> writer = RecordingWriter::create(folder, truth.intrinsics());
    if (!writer)
        return writer.error();
    for (std::uint64_t k = 0; k < static_cast<std::uint64_t>(options.frames); ++k)
        if (Status added = writer->add(time_ns(k, period_ms), truth.luma(k), truth.depth(k));
            !added)
            return added;
    return ok();
}

Status record_two(SyntheticOptions options, const char *folder, int period_ms) {
    options.rig = select_rigs({"320x240", "1280x720", "25mm", "color"}).front().geometry().rig;
    options.fps = 1000.0 / period_ms;
    options.motion = options.fps / 30;
    return testing::record_rig(options, folder);
}

} // namespace

int main(int argc, char **argv) {
    const bool is_rig = argc == 5 && std::strcmp(argv[4], "rig") == 0;
    if (argc != 4 && argc != 6 && !is_rig) {
        std::fprintf(stderr, "usage: record_room DIR FRAMES PERIOD_MS [WIDTH HEIGHT | rig]\n");
        return 2;
    }
    SyntheticOptions options;
    options.frames = std::atoi(argv[2]);
    const int period_ms = std::atoi(argv[3]);
    options.width = argc == 6 ? std::atoi(argv[4]) : 160;
    options.height = argc == 6 ? std::atoi(argv[5]) : 120;
    const Status done = is_rig ? record_two(options, argv[1], period_ms)
                               : record_registered(options, argv[1], period_ms);
    if (!done)
        std::fprintf(stderr, "record_room: %s\n", done.error().message.c_str());
    return done ? 0 : 1;
}
