// SPDX-License-Identifier: Apache-2.0
// record_room DIR FRAMES PERIOD_MS [WIDTH HEIGHT]: records the synthetic room, 160x120, as a
// recording.
#include "drivers/files/write_recording.hpp"
#include "drivers/simulated/synthetic/truth.hpp"

#include <cstdio>
#include <cstdlib>

int main(int argc, char **argv) {
    using namespace afterglow;
    if (argc != 4 && argc != 6) {
        std::fprintf(stderr, "usage: record_room DIR FRAMES PERIOD_MS [WIDTH HEIGHT]\n");
        return 2;
    }
    SyntheticOptions options;
    options.width = argc == 6 ? std::atoi(argv[4]) : 160;
    options.height = argc == 6 ? std::atoi(argv[5]) : 120;
    SyntheticTruth truth(options);
    Result<RecordingWriter> writer = RecordingWriter::create(argv[1], truth.intrinsics());
    for (std::uint64_t k = 0; writer && k < std::strtoull(argv[2], nullptr, 10); ++k) {
        const auto t_ns = static_cast<std::int64_t>(k) * std::atoi(argv[3]) * 1'000'000;
        if (!writer->add(t_ns, truth.luma(k), truth.depth(k)))
            return 1;
    }
    return writer ? 0 : 1;
}
