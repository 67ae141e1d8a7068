// SPDX-License-Identifier: Apache-2.0
#include "capture/depth_pairing.hpp"
#include "tests/allocation_count.hpp"
#include "tests/catch.hpp"

#include <deque>
#include <string>

using namespace afterglow;
using namespace std::chrono_literals;

namespace {

constexpr int width = 64;
constexpr int height = 48;
constexpr std::int64_t ms = 1'000'000;

/// A depth map to come: when it was taken, and what it shows.
struct Coming {
    std::int64_t t_ns;
    std::uint16_t depth_mm = 1500;
    int hole_columns = 0;    ///< without depth, from the left
    int amplitude_width = 0; ///< 0: it has none; else that of a column is its number
};

/// A TOF camera that gives what the test has laid out, and remembers how long it was waited for.
class FakeTof final : public TofSource {
public:
    std::deque<Coming> maps;
    std::chrono::nanoseconds waited{};

    const Intrinsics &intrinsics() const override { return camera_; }
    Status start() override { return ok(); }
    void stop() override {}
    Capture read(DepthFrame &frame, std::chrono::nanoseconds timeout) override {
        waited = timeout;
        if (maps.empty())
            return Capture::none;
        const Coming map = maps.front();
        maps.pop_front();
        frame.t_ns = map.t_ns;
        for (int v = 0; v < height; ++v)
            for (int u = 0; u < width; ++u)
                frame.depth(u, v) = u < map.hole_columns ? 0 : map.depth_mm;
        frame.amplitude = Image<std::uint16_t>(map.amplitude_width, height);
        for (int v = 0; v < height; ++v)
            for (int u = 0; u < map.amplitude_width; ++u)
                frame.amplitude(u, v) = static_cast<std::uint16_t>(u);
        return Capture::frame;
    }
    const std::string &problem() const override { return problem_; }

private:
    Intrinsics camera_ = {60, 60, 32, 24, width, height};
    std::string problem_ = "told to fail";
};

/// A light that was on from a time on.
class FakeLight final : public Illuminator {
public:
    std::int64_t since_ns = 0;
    Status set(bool /*lit*/) override { return ok(); }
    bool lit() const override { return true; }
    bool was_lit(std::int64_t t_ns) const override { return t_ns >= since_ns; }
};

struct Fixture {
    explicit Fixture(const Pairing &options = {})
        : pairing(options, FakeTof().intrinsics()), estimated_map(width, height, 1500) {
        estimate.source = FrameSource::none;
    }
    Capture read(std::int64_t t_ns) { return pairing.read(tof, light, t_ns, estimate); }

    FakeTof tof;
    FakeLight light;
    DepthPairing pairing;
    DepthMap estimated_map;
    Estimate estimate;
};

Pairing settling_in(int maps) {
    Pairing pairing;
    pairing.warmup_maps = maps;
    return pairing;
}

} // namespace

TEST_CASE("a depth map that arrives before its image is kept for it") {
    Fixture fixture;
    fixture.tof.maps = {{133 * ms, 1000}, {166 * ms, 2000}};
    CHECK(fixture.read(100 * ms) == Capture::none);
    CHECK(fixture.read(133 * ms) == Capture::frame);
    CHECK(fixture.pairing.depth()(0, 0) == 1000);
    CHECK(fixture.read(166 * ms) == Capture::frame);
    CHECK(fixture.pairing.depth()(0, 0) == 2000);
}

TEST_CASE("a depth map one second ahead of its image is kept at a low frame rate") {
    Pairing slow;
    slow.furthest_ahead = std::chrono::seconds(2);
    Fixture fixture(slow);
    fixture.tof.maps = {{1100 * ms}};
    CHECK(fixture.read(100 * ms) == Capture::none);
    CHECK(fixture.read(1100 * ms) == Capture::frame);
}

TEST_CASE("a depth map far ahead of its image is discarded as a clock error") {
    Fixture fixture;
    fixture.tof.maps = {{1000 * ms}, {100 * ms}};
    CHECK(fixture.read(100 * ms) == Capture::damaged);
    CHECK(fixture.pairing.problem() == "the depth map belongs to no image");
    CHECK(fixture.read(100 * ms) == Capture::frame);
}

TEST_CASE("depth pairing subtracts the constant delay and applies the configured tolerance") {
    Pairing options;
    options.tolerance = 5ms;
    options.delay = -30ms;
    Fixture fixture(options);
    fixture.tof.maps = {{124 * ms}, {126 * ms}};
    CHECK(fixture.read(100 * ms) == Capture::frame); // 6 ms early, 4 ms early
    CHECK(fixture.pairing.t_ns() == 96 * ms);
    CHECK(fixture.tof.maps.empty());
}

TEST_CASE("a depth map exposed with the light off is not a measurement") {
    Fixture fixture;
    fixture.light.since_ns = 101 * ms;
    fixture.tof.maps = {{100 * ms}, {133 * ms}};
    CHECK(fixture.read(100 * ms) == Capture::none);
    CHECK(fixture.read(133 * ms) == Capture::frame);
}

TEST_CASE("an image waits for its depth map no longer than configured") {
    Pairing options;
    options.wait = 20ms;
    Fixture fixture(options);
    CHECK(fixture.read(100 * ms) == Capture::none);
    CHECK(fixture.tof.waited > 10ms);
    CHECK(fixture.tof.waited <= 20ms);
    Fixture hasty;
    CHECK(hasty.read(100 * ms) == Capture::none);
    CHECK(hasty.tof.waited == 0ms);
}

TEST_CASE("TOF warm-up: maps are skipped until two consecutive maps agree") {
    Fixture fixture(settling_in(10));
    fixture.tof.maps = {{100 * ms, 1500, 60},
                        {133 * ms, 1900, 20},
                        {166 * ms, 1510, 4},
                        {200 * ms, 1500, 4},
                        {233 * ms, 900, 40}};
    CHECK(fixture.read(100 * ms) == Capture::none);
    CHECK(fixture.read(133 * ms) == Capture::none); // far more of it is there
    CHECK(fixture.read(166 * ms) == Capture::none); // 20 % nearer
    CHECK(fixture.read(200 * ms) == Capture::frame);
    CHECK(fixture.read(233 * ms) == Capture::frame); // the light has not gone out since
}

TEST_CASE("TOF warm-up: a map that matches the estimate is accepted at once") {
    Fixture fixture(settling_in(10));
    fixture.estimate.source = FrameSource::estimated;
    fixture.estimate.depth = fixture.estimated_map;
    fixture.tof.maps = {{100 * ms, 1530}};
    CHECK(fixture.read(100 * ms) == Capture::frame);
    fixture.pairing.relit();
    fixture.tof.maps = {{133 * ms, 1500, 20}, {166 * ms, 1700}, {200 * ms, 1690}};
    CHECK(fixture.read(133 * ms) == Capture::none);  // a third is missing
    CHECK(fixture.read(166 * ms) == Capture::none);  // elsewhere, and nothing confirms it
    CHECK(fixture.read(200 * ms) == Capture::frame); // the scene has changed
}

TEST_CASE("TOF warm-up: a map is accepted when the maximum number has been skipped") {
    Fixture fixture(settling_in(3));
    std::uint16_t depth = 1000;
    for (int image = 1; image <= 4; ++image) {
        depth = static_cast<std::uint16_t>(depth + 100);
        fixture.tof.maps = {{image * 33 * ms, depth}};
        CHECK(fixture.read(image * 33 * ms) == (image < 4 ? Capture::none : Capture::frame));
    }
}

TEST_CASE("readings of less than the least amplitude are no readings") {
    Pairing options;
    options.least_amplitude = 10;
    Fixture fixture(options);
    fixture.tof.maps = {{100 * ms, 1500, 0, width}, {133 * ms}};
    CHECK(fixture.read(100 * ms) == Capture::frame);
    CHECK(fixture.pairing.depth()(9, 5) == 0);
    CHECK(fixture.pairing.depth()(10, 5) == 1500);
    CHECK(fixture.pairing.amplitude()(10, 5) == 10);
    CHECK(fixture.read(133 * ms) == Capture::frame); // of which no amplitude is known
    CHECK(fixture.pairing.depth()(9, 5) == 1500);
    CHECK(fixture.pairing.amplitude().empty());
}

TEST_CASE("an amplitude of another size than its depth map is damage") {
    Fixture fixture;
    fixture.tof.maps = {{100 * ms, 1500, 0, width / 2}, {133 * ms}};
    CHECK(fixture.read(100 * ms) == Capture::damaged);
    CHECK(fixture.pairing.problem() == "the amplitude has not the size of its depth map");
    CHECK(fixture.read(133 * ms) == Capture::frame);
}

TEST_CASE("depth pairing allocates nothing") {
    Fixture fixture(settling_in(10));
    for (int map = 1; map <= 20; ++map)
        fixture.tof.maps.push_back({map * 33 * ms, static_cast<std::uint16_t>(1000 + 100 * map)});
    const std::uint64_t before = allocation_count();
    for (int map = 1; map <= 20; ++map)
        fixture.read(map * 33 * ms);
    CHECK(allocation_count() == before);
}
