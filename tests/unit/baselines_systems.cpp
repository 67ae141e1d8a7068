// SPDX-License-Identifier: Apache-2.0
#include "drivers/simulated/synthetic/truth.hpp"
#include "eval/baselines/systems.hpp"
#include "eval/scoring/metrics.hpp"
#include "tests/catch.hpp"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <random>
#include <set>
#include <string>
#include <utility>
#include <vector>

using namespace afterglow;

namespace {

constexpr std::int64_t frame_ns = 33'333'333;

/// A few images of the synthetic room, walked through by hand, and their true depth.
struct Walk {
    Intrinsics camera;
    std::vector<Luma> luma;
    std::vector<DepthMap> depth;
};

/// Made once: the room is the slow part of these tests.
const Walk &room_walk() {
    static const Walk walk = [] {
        SyntheticOptions options;
        options.width = 320;
        options.height = 240;
        options.noise = false;
        SyntheticTruth truth(options);
        Walk w{.camera = truth.intrinsics(), .luma = {}, .depth = {}};
        for (std::uint64_t k = 0; k < 6; ++k) {
            w.luma.push_back(truth.luma(30 + k));
            w.depth.push_back(truth.depth(30 + k));
        }
        return w;
    }();
    return walk;
}

/// The true depth of image k, which is shown at (k + 1) frame_ns.
Result<DepthMap> walk_truth(std::int64_t t_ns) {
    return room_walk().depth[static_cast<std::size_t>(t_ns / frame_ns - 1)];
}

std::unique_ptr<Pipeline> make(const SystemDescription &system, WorkerPool &pool,
                               TruthAt truth = walk_truth) {
    return system_factory(system, {.options = {}, .pool = pool, .truth = std::move(truth)})(
        room_walk().camera);
}

DepthMap copy_of(DepthView depth) {
    DepthMap copy(depth.width(), depth.height());
    for (int v = 0; v < depth.height(); ++v)
        std::copy_n(depth.row(v), depth.width(), copy.row(v));
    return copy;
}

/// The maps that a system gives for the walk, measured at its beginning alone.
std::vector<DepthMap> maps_of(const SystemDescription &system, int workers) {
    const Walk &walk = room_walk();
    WorkerPool pool(workers);
    const auto made = make(system, pool);
    std::vector<DepthMap> maps;
    for (std::size_t k = 0; k < walk.luma.size(); ++k) {
        const Estimate &e = made->track(walk.luma[k], static_cast<std::int64_t>(k + 1) * frame_ns);
        if (k == 0 && system.lighting != Lighting::never)
            made->measure(walk.depth[k]);
        maps.push_back(copy_of(e.depth));
    }
    return maps;
}

/// Estimates give a finite pose and coverage that tells the truth, whatever they were made of.
void check_sound(const Estimate &e) {
    CHECK(e.pose.is_finite());
    const DepthMap depth = copy_of(e.depth);
    const auto covered = std::ranges::count_if(depth.pixels(), [](auto z) { return z != 0; });
    CHECK(e.coverage == Approx(100.0 * static_cast<double>(covered) /
                               static_cast<double>(depth.pixels().size())));
    CHECK((e.source != FrameSource::none || covered == 0));
}

} // namespace

TEST_CASE("depth systems have unique names, and the paper's own comes first", "[baselines]") {
    std::set<std::string> names;
    WorkerPool pool(1);
    for (const SystemDescription &system : systems()) {
        CHECK(names.insert(std::string(system.name)).second);
        CHECK_FALSE(system.title.empty());
        make(system, pool);
    }
    CHECK(systems().front().name == "paper");
    CHECK_FALSE(find_system("papers"));
}

TEST_CASE("every depth system follows a camera that moves through a room", "[baselines]") {
    const Walk &walk = room_walk();
    for (const SystemDescription &system : systems()) {
        INFO(system.name);
        const auto maps = maps_of(system, 2);
        // Sparse two-view depth of neighbouring images is coarse: Noraky & Sze 2019's own is 38 %
        // off.
        const double worst_mre = system.dense ? 3 : 60;
        const double least_coverage = system.dense ? 80 : 0.02;
        for (std::size_t k = 1; k < maps.size(); ++k) {
            const DepthErrors errors = compare_depth(maps[k], walk.depth[k]);
            CHECK(errors.mre < worst_mre);
            CHECK(errors.coverage() > least_coverage);
        }
    }
}

TEST_CASE("every depth system gives identical results for any number of workers", "[baselines]") {
    for (const SystemDescription &system : systems()) {
        INFO(system.name);
        const auto once = maps_of(system, 2);
        CHECK(once == maps_of(system, 2));
        CHECK(once == maps_of(system, 1));
    }
}

TEST_CASE("every depth system publishes a measured map unchanged", "[baselines]") {
    const Walk &walk = room_walk();
    WorkerPool pool(1);
    for (const SystemDescription &system : systems()) {
        if (system.lighting == Lighting::never)
            continue;
        INFO(system.name);
        const auto made = make(system, pool);
        CHECK(made->track(walk.luma[0], frame_ns).wants_measurement);
        const Estimate &e = made->measure(walk.depth[0]);
        CHECK(e.source == FrameSource::measured);
        CHECK(copy_of(e.depth) == walk.depth[0]);
        CHECK_FALSE(e.wants_measurement);
        CHECK(made->track(walk.luma[1], 2 * frame_ns).age_frames == 1);
    }
}

TEST_CASE("every depth system survives noise, blank images and impossible depth", "[baselines]") {
    const Walk &walk = room_walk();
    WorkerPool pool(2);
    const int width = walk.camera.width;
    const int height = walk.camera.height;
    for (const SystemDescription &system : systems()) {
        INFO(system.name);
        DepthMap depth(width, height);
        const auto made = make(system, pool, [&](std::int64_t) { return Result<DepthMap>(depth); });
        std::mt19937 random(3);
        std::int64_t t_ns = 0;
        for (int kind = 0; kind < 12; ++kind) {
            Luma image(width, height, static_cast<std::uint8_t>(kind % 4 == 0 ? 0 : 255));
            if (kind % 4 == 1)
                for (std::uint8_t &pixel : image.pixels())
                    pixel = static_cast<std::uint8_t>(random());
            if (kind % 4 == 2)
                image = walk.luma[1];
            depth = DepthMap(width, height, static_cast<std::uint16_t>(kind % 3 == 0 ? 0 : 65535));
            if (kind % 3 == 2)
                for (std::uint16_t &z : depth.pixels())
                    z = static_cast<std::uint16_t>(random() % 2 ? random() : 0);
            check_sound(made->track(image, t_ns += frame_ns));
            check_sound(made->measure(depth));
            check_sound(made->track(walk.luma[2], t_ns += frame_ns));
        }
    }
}

TEST_CASE("no depth system invents depth from a map of zeros", "[baselines]") {
    const Walk &walk = room_walk();
    WorkerPool pool(1);
    for (const SystemDescription &system : systems()) {
        INFO(system.name);
        const DepthMap nothing(walk.camera.width, walk.camera.height);
        const auto made =
            make(system, pool, [&](std::int64_t) { return Result<DepthMap>(nothing); });
        made->track(walk.luma[0], frame_ns);
        if (system.lighting != Lighting::never)
            made->measure(nothing);
        const Estimate &e = made->track(walk.luma[1], 2 * frame_ns);
        CHECK(e.coverage == 0);
    }
}

TEST_CASE("variants of the paper's pipeline differ from it in the replaced stage", "[baselines]") {
    const Walk &walk = room_walk();
    const auto maps = [](std::string_view name) {
        const SystemDescription *system = find_system(name);
        REQUIRE(system);
        return maps_of(*system, 1);
    };
    const auto coverage = [&](const std::vector<DepthMap> &of) {
        return compare_depth(of.back(), walk.depth.back()).coverage();
    };
    const auto paper = maps("paper");

    SECTION("reverse warping leaves no cracks and fills disocclusions") {
        CHECK(coverage(maps("reverse-warp")) > coverage(paper));
    }
    SECTION("the median filter fills cracks") {
        CHECK(coverage(maps("median")) > coverage(paper));
    }
    SECTION("sub-pixel Lucas-Kanade flow lowers the error") {
        CHECK(compare_depth(maps("lk").back(), walk.depth.back()).mre <
              compare_depth(paper.back(), walk.depth.back()).mre);
    }
    SECTION("OpenCV's odometry does not drift from the measured map") {
        CHECK(compare_depth(maps("opencv-rgbd").back(), walk.depth.back()).mre < 0.6);
    }
}
