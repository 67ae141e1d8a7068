// SPDX-License-Identifier: Apache-2.0
//
// record_boards FOLDER BOARD CALIBRATION STILLS MOVING: what "afterglow-calibrate capture" would
// record of a rig that is known (a calibration file): STILLS views of a board at rest, and MOVING
// images and depth maps of a board that is waved, 30 a second. For tests, and the pictures of
// docs/calibration.md.
#include "config/calibration_file.hpp"
#include "tests/simulated_boards.hpp"
#include "tools/calibrate/captures.hpp"

#include <fmt/format.h>

#include <cstdio>
#include <cstdlib>

using namespace afterglow;

namespace {

Status record(const std::string &folder, const Board &board, const RigCalibration &rig, int stills,
              int moving) {
    Result<CapturesWriter> writer = CapturesWriter::create(folder, board);
    if (!writer)
        return writer.error();
    SimulatedBoards world(rig, board);
    Status written = ok();
    for (const Pose &pose : world.rests(stills)) {
        const BoardMotion rest = [&](double) { return pose; };
        const SimulatedBoards::TofFrame tof = world.tof(rest, 0);
        if (written)
            written = writer->add_still(world.image(rest, 0), tof.depth, tof.amplitude);
    }
    for (int k = 0; k < moving && written; ++k) {
        const std::int64_t image_ns = 1'000'000'000 + k * 33'333'333LL,
                           map_ns = image_ns + 4'000'000;
        const auto tof = world.tof(SimulatedBoards::wave, static_cast<double>(map_ns) / 1e9);
        written = writer->add_moving_color(
            image_ns, world.image(SimulatedBoards::wave, static_cast<double>(image_ns) / 1e9));
        if (written)
            written = writer->add_moving_tof(map_ns, tof.depth, tof.amplitude);
    }
    return written;
}

} // namespace

int main(int argc, char **argv) {
    if (argc != 6) {
        fmt::print(stderr, "record_boards FOLDER BOARD CALIBRATION STILLS MOVING\n");
        return 2;
    }
    const auto board = parse_board(argv[2]);
    const auto rig = load_calibration(argv[3]);
    const Status done = !board ? Status(board.error())
                        : !rig
                            ? Status(rig.error())
                            : record(argv[1], *board, *rig, std::atoi(argv[4]), std::atoi(argv[5]));
    if (!done)
        fmt::print(stderr, "record_boards: {}\n", done.error().message);
    return done ? 0 : 1;
}
