// SPDX-License-Identifier: Apache-2.0
#include "drivers/files/write_recording.hpp"
#include "eval/experiments/sequence.hpp"
#include "eval/experiments/watch.hpp"
#include "tests/catch.hpp"
#include "tests/temporary_folder.hpp"

using namespace afterglow;

TEST_CASE("a sequence in memory keeps when its depth maps were taken", "[report]") {
    constexpr std::int64_t begin = 7'000'000'000, interval = 40'000'000, after = 12'000'000;
    const TemporaryFolder folder;
    auto writer = RecordingWriter::create(folder / "r", {20, 20, 7.5, 5.5, 16, 12});
    REQUIRE(writer);
    for (int k = 0; k < 3; ++k)
        REQUIRE(writer->add(begin + k * interval, Luma(16, 12), begin + k * interval + after,
                            DepthMap(16, 12, 1000), std::nullopt));
    Watch watch(3);
    const Result<Sequence> sequence = load_sequence(folder / "r", 0, watch);
    REQUIRE(sequence);
    REQUIRE(sequence->frames.size() == 3);
    for (const double repeated_fps : {0.0, 50.0}) {
        const Footage footage = footage_of(*sequence, repeated_fps);
        ColorFrame color{Luma(16, 12)};
        DepthFrame depth{DepthMap(16, 12)};
        REQUIRE(footage.rig.color->start());
        REQUIRE(footage.rig.tof->start());
        for (int k = 0; k < 3; ++k) {
            CAPTURE(repeated_fps, k);
            REQUIRE(footage.rig.illuminator->set(true));
            REQUIRE(footage.rig.color->read(color, std::chrono::seconds(1)) == Capture::frame);
            REQUIRE(footage.rig.tof->read(depth, std::chrono::seconds(1)) == Capture::frame);
            CHECK(depth.t_ns - color.t_ns == after);
        }
    }
}
