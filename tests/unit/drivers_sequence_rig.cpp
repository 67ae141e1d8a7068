// SPDX-License-Identifier: Apache-2.0
#include "drivers/simulated/sequence_rig.hpp"
#include "tests/catch.hpp"

#include <set>
#include <vector>

using namespace afterglow;
using namespace std::chrono_literals;

namespace {

constexpr std::int64_t interval_ns = 30'000'000;

/// Ten images, 30 ms apart from 5 s on, of pixels k; remembers whose depth was asked for.
class NumberedImages : public FrameSequence {
public:
    NumberedImages(std::vector<std::uint64_t> &depths_read, std::set<std::uint64_t> damaged)
        : depths_read_(depths_read), damaged_(std::move(damaged)) {}
    const Intrinsics &intrinsics() const override { return camera_; }
    std::optional<std::int64_t> time_ns(std::uint64_t k) const override {
        if (k >= 10)
            return std::nullopt;
        return 5'000'000'000 + static_cast<std::int64_t>(k) * interval_ns;
    }
    Status read_luma(std::uint64_t k, ImageView<std::uint8_t> luma) override {
        luma(0, 0) = static_cast<std::uint8_t>(k);
        return damaged_.count(k) > 0 ? Status(Error{"image is damaged", 0}) : ok();
    }
    Status read_depth(std::uint64_t k, ImageView<std::uint16_t> depth) override {
        depths_read_.push_back(k);
        depth(0, 0) = static_cast<std::uint16_t>(k);
        return damaged_.count(k) > 0 ? Status(Error{"depth is damaged", 0}) : ok();
    }

private:
    Intrinsics camera_{10, 10, 0, 0, 2, 2};
    std::vector<std::uint64_t> &depths_read_;
    std::set<std::uint64_t> damaged_;
};

/// Time that passes only when somebody sleeps, or the test says so.
struct ManualClock : Clock {
    std::int64_t now = 1'000'000'000'000;
    std::int64_t now_ns() const override { return now; }
    void sleep_until(std::int64_t t_ns) override { now = std::max(now, t_ns); }
};

struct Bench {
    explicit Bench(const Playback &playback, std::set<std::uint64_t> damaged = {})
        : rig(make_rig(std::make_unique<NumberedImages>(depths_read, std::move(damaged)), playback,
                       clock)) {
        color.luma = Luma(2, 2);
        depth.depth = DepthMap(2, 2);
        REQUIRE(rig.color->start());
        REQUIRE(rig.tof->start());
    }
    Capture image(std::chrono::nanoseconds timeout = 1s) { return rig.color->read(color, timeout); }
    Capture map() { return rig.tof->read(depth, 0ns); }
    /// Reads on to image k.
    void go_to(std::uint64_t k) {
        do
            REQUIRE(image() == Capture::frame);
        while (color.sequence < k);
    }
    void light(bool lit) { REQUIRE(rig.illuminator->set(lit)); }

    std::shared_ptr<ManualClock> clock = std::make_shared<ManualClock>();
    std::vector<std::uint64_t> depths_read;
    Rig rig;
    ColorFrame color;
    DepthFrame depth;
};

constexpr Playback fast{.real_time = false};

} // namespace

TEST_CASE("a rig without real time gives every image with its timestamp, then the end") {
    Bench bench(fast);
    for (std::uint64_t k = 0; k < 10; ++k) {
        REQUIRE(bench.image() == Capture::frame);
        CHECK(bench.color.sequence == k);
        CHECK(bench.color.luma(0, 0) == k);
        CHECK(bench.color.t_ns == 5'000'000'000 + static_cast<std::int64_t>(k) * interval_ns);
    }
    CHECK(bench.image() == Capture::ended);
    CHECK(bench.image() == Capture::ended);
    CHECK(bench.clock->now == 1'000'000'000'000);
}

TEST_CASE("a rig stops after the configured number of images") {
    Bench bench({.real_time = false, .frames = 2});
    bench.go_to(1);
    CHECK(bench.image() == Capture::ended);
}

TEST_CASE("a rig reads no depth while the light is off") {
    Bench bench(fast);
    for (int i = 0; i < 10; ++i) {
        bench.image();
        CHECK(bench.map() == Capture::none);
    }
    CHECK(bench.depths_read.empty());
}

TEST_CASE("a rig's depth arrives after the wake latency in images") {
    const int latency = GENERATE(0, 1, 3);
    Bench bench({.real_time = false, .wake_latency_frames = latency});
    bench.go_to(2);
    bench.light(true);
    std::vector<std::uint64_t> arrived;
    for (int k = 2; k < 8; ++k) {
        if (bench.map() == Capture::frame) {
            CHECK(bench.depth.sequence == bench.color.sequence);
            CHECK(bench.depth.t_ns == bench.color.t_ns);
            CHECK(bench.depth.depth(0, 0) == bench.color.sequence);
            arrived.push_back(bench.depth.sequence);
        }
        CHECK(bench.map() == Capture::none); // one map an image
        bench.image();
    }
    std::vector<std::uint64_t> expected;
    for (int k = 2 + latency; k < 8; ++k)
        expected.push_back(static_cast<std::uint64_t>(k));
    CHECK(arrived == expected);
    CHECK(bench.depths_read == expected);
}

TEST_CASE("a rig's wake latency starts again after the light was off") {
    Bench bench({.real_time = false, .wake_latency_frames = 2});
    bench.go_to(0);
    bench.light(true);
    bench.go_to(2);
    CHECK(bench.map() == Capture::frame);
    bench.light(true); // lit already: nothing begins anew
    bench.go_to(3);
    CHECK(bench.map() == Capture::frame);
    bench.light(false);
    CHECK_FALSE(bench.rig.illuminator->lit());
    bench.light(true);
    CHECK(bench.map() == Capture::none);
    bench.go_to(4);
    CHECK(bench.map() == Capture::none);
    bench.go_to(5);
    CHECK(bench.map() == Capture::frame);
    CHECK(bench.depths_read == std::vector<std::uint64_t>{2, 3, 5});
}

TEST_CASE("a rig's wake latency counts from the first image when lit before") {
    Bench bench({.real_time = false, .wake_latency_frames = 1});
    bench.light(true);
    CHECK(bench.map() == Capture::none);
    bench.go_to(0);
    CHECK(bench.map() == Capture::none);
    bench.go_to(1);
    CHECK(bench.map() == Capture::frame);
}

TEST_CASE("a rig's camera gives no frames before it is started") {
    Bench bench(fast);
    bench.light(true);
    bench.go_to(0);
    bench.rig.tof->stop();
    CHECK(bench.map() == Capture::none);
    REQUIRE(bench.rig.tof->start());
    CHECK(bench.map() == Capture::frame);
    bench.rig.color->stop();
    CHECK(bench.image() == Capture::none);
}

TEST_CASE("a rig's restarted colour camera begins at the first image") {
    Bench bench(fast);
    bench.go_to(9);
    CHECK(bench.image() == Capture::ended);
    REQUIRE(bench.rig.color->start());
    REQUIRE(bench.image() == Capture::frame);
    CHECK(bench.color.sequence == 0);
}

TEST_CASE("a rig reports a damaged frame and continues with the next") {
    Bench bench(fast, {1});
    bench.go_to(0);
    CHECK(bench.image() == Capture::damaged);
    CHECK(bench.rig.color->problem() == "image is damaged");
    bench.light(true);
    CHECK(bench.map() == Capture::damaged);
    CHECK(bench.rig.tof->problem() == "depth is damaged");
    CHECK(bench.image() == Capture::frame);
    CHECK(bench.color.sequence == 2);
    CHECK(bench.map() == Capture::frame);
}

TEST_CASE("destroying a rig's illuminator switches its light off") {
    Bench bench(fast);
    bench.light(true);
    bench.rig.illuminator.reset();
    bench.go_to(0);
    CHECK(bench.map() == Capture::none);
}

TEST_CASE("a real-time rig delivers an image when it is due, with that timestamp") {
    Bench bench({.real_time = true});
    const std::int64_t start = bench.clock->now;
    for (int k = 0; k < 10; ++k) {
        REQUIRE(bench.image() == Capture::frame);
        CHECK(bench.clock->now == start + k * interval_ns);
        CHECK(bench.color.t_ns == bench.clock->now);
    }
    CHECK(bench.image() == Capture::ended);
}

TEST_CASE("a real-time rig's read does not exceed its timeout") {
    Bench bench({.real_time = true});
    REQUIRE(bench.image() == Capture::frame);
    const std::int64_t start = bench.clock->now;
    CHECK(bench.image(10ms) == Capture::none);
    CHECK(bench.clock->now == start + 10'000'000);
    CHECK(bench.image(std::chrono::nanoseconds::max()) == Capture::frame);
    CHECK(bench.color.sequence == 1);
}

TEST_CASE("a real-time rig's late reader misses images and sees the gap") {
    Bench bench({.real_time = true, .wake_latency_frames = 2});
    bench.go_to(0);
    bench.light(true);
    bench.clock->now += interval_ns * 3 + interval_ns / 2;
    REQUIRE(bench.image() == Capture::frame);
    CHECK(bench.color.sequence == 3); // 1 and 2 are past, 3 is the last that is due
    CHECK(bench.color.t_ns == bench.clock->now - interval_ns / 2);
    CHECK(bench.map() == Capture::frame);
    CHECK(bench.depths_read == std::vector<std::uint64_t>{3});
    REQUIRE(bench.image() == Capture::frame);
    CHECK(bench.color.sequence == 4);
    bench.clock->now += interval_ns * 100;
    REQUIRE(bench.image() == Capture::frame);
    CHECK(bench.color.sequence == 9); // there is no later one to make it worthless
    CHECK(bench.image() == Capture::ended);
}

TEST_CASE("a real-time rig's reader late by less than one period misses no image") {
    Bench bench({.real_time = true});
    for (std::uint64_t k = 0; k < 10; ++k) {
        REQUIRE(bench.image() == Capture::frame);
        CHECK(bench.color.sequence == k);
        bench.clock->now = bench.color.t_ns + interval_ns + interval_ns / 2;
    }
}
