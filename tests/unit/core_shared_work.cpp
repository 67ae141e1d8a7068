// SPDX-License-Identifier: Apache-2.0
//
// ThreadSanitizer looks at all that workers share of a frame.
#include "core/keyframe/keyframe_pipeline.hpp"
#include "drivers/simulated/synthetic/truth.hpp"
#include "tests/catch.hpp"

#include <algorithm>
#include <cstdint>
#include <vector>

using namespace afterglow;

TEST_CASE("workers that share all frames of a pipeline make the same maps", "[core][tsan]") {
    SyntheticTruth room({.width = 320, .height = 240, .fps = 30, .seed = 1});
    const auto maps_by = [&](int workers) {
        WorkerPool pool(workers);
        KeyframePipeline pipeline(KeyframeOptions{}, room.intrinsics(), pool);
        std::vector<DepthMap> maps;
        for (std::uint64_t k = 0; k < 6; ++k) {
            const Estimate &e =
                pipeline.track(room.luma(k), static_cast<std::int64_t>(k + 1) * 33'333'333);
            DepthMap &map = maps.emplace_back(e.depth.width(), e.depth.height());
            for (int v = 0; v < map.height(); ++v)
                std::copy_n(e.depth.row(v), map.width(), map.row(v));
            if (k % 3 == 0)
                pipeline.measure(room.depth(k));
        }
        return maps;
    };
    CHECK(maps_by(3) == maps_by(1));
}
