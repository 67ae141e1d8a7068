// SPDX-License-Identifier: Apache-2.0
#include "drivers/simulated/synthetic/synthetic.hpp"
#include "tests/catch.hpp"
#include "tests/fake_cameras.hpp"
#include "tools/characterise/characterise.hpp"
#include "tools/characterise/report.hpp"

#include <cmath>
#include <functional>
#include <random>
#include <string>
#include <utility>

using namespace afterglow;
using afterglow::testing::FakeCameras;

namespace {

const std::atomic<bool> go_on = false;

/// A camera on a tripod in the furnished room; as fast as it can be drawn.
SyntheticOptions on_tripod() {
    return {.width = 320, .height = 240, .real_time = false, .motion = 0};
}

Result<Characteristics> characterise_room(const TofNoise &tof,
                                          const SyntheticOptions &room = on_tripod(),
                                          CharacteriseOptions options = {.seconds = 15}) {
    SyntheticWorld world = make_world(room);
    world.tof = tof;
    auto rig = open_synthetic(room, std::move(world));
    REQUIRE(rig);
    return characterise(*rig, options, go_on);
}

float curve(const SensorNoise &noise, float z) {
    return noise.floor_m + z * (noise.linear + z * noise.quadratic_per_m);
}

/// What characterise() refuses with.
std::string refusal(const Result<Characteristics> &found) {
    return found ? "" : found.error().message;
}

bool contains(const std::string &text, const std::string &part) {
    return text.find(part) != std::string::npos;
}

} // namespace

TEST_CASE("the noise of a simulated TOF camera is found within 10 % over the depths seen",
          "[characterise][long]") {
    TofNoise tof;
    std::tie(tof.sigma_at_0, tof.sigma_per_square) =
        GENERATE(std::pair(0.002, 0.001), std::pair(0.004, 0.0), std::pair(0.001, 0.004));
    INFO(tof.sigma_at_0 << " + " << tof.sigma_per_square << " z^2");
    const Result<Characteristics> found = characterise_room(tof);
    INFO(refusal(found));
    REQUIRE(found);
    CHECK_FALSE(found->fit.scaled);
    CHECK(found->bins.back().z_m > 1.5F * found->bins.front().z_m);
    for (const DepthBin &bin : found->bins) {
        INFO(bin.z_m);
        const double truth = tof.sigma_at_0 + tof.sigma_per_square * bin.z_m * bin.z_m;
        CHECK(bin.sigma_m == Approx(truth).epsilon(0.1));
        CHECK(curve(found->fit.noise, bin.z_m) == Approx(truth).epsilon(0.1));
    }
    CHECK(found->shared_noise == Approx(0.2).margin(0.03)); // neighbours share nothing
}

TEST_CASE("the flying pixels of a simulated TOF camera are counted", "[characterise][long]") {
    TofNoise tof;
    tof.flying = GENERATE(0.0, 0.3, 0.5);
    INFO(tof.flying);
    const Result<Characteristics> found = characterise_room(tof);
    REQUIRE(found);
    REQUIRE(found->edges.crossings > 100);
    // One pixel on each side; of those, a tenth of the step on either side is not told from a
    // surface.
    CHECK(found->edges.flying == Approx(2 * tof.flying * 0.8).epsilon(0.25).margin(0.08));
    if (tof.flying == 0)
        CHECK(found->edges.misplaced_px < 0.15);
    else // of each of both pixels a share, uniform, with that chance
        CHECK(found->edges.misplaced_px ==
              Approx(std::sqrt(2 * (tof.flying / 3 - std::pow(tof.flying / 2, 2)))).epsilon(0.25));
}

TEST_CASE("a camera that moves is not characterised", "[characterise]") {
    SyntheticOptions room = on_tripod();
    room.motion = GENERATE(0.05, 1.0);
    const Result<Characteristics> found = characterise_room({}, room, {.seconds = 10});
    CHECK(contains(refusal(found), "the view was not still"));
}

TEST_CASE("the maps of a light that warms up are counted", "[characterise]") {
    FakeCameras cameras;
    const int unsettled = GENERATE(0, 1, 6);
    INFO(unsettled);
    int since_light = 0;
    std::mt19937 random(1);
    std::normal_distribution<double> noise(0, 3);
    cameras.read_tof = [&](DepthFrame &frame) {
        if (!cameras.lit)
            since_light = 0;
        if (!cameras.lit || cameras.measured_ns == cameras.t_ns)
            return Capture::none;
        cameras.give_depth(frame);
        for (std::uint16_t &mm : frame.depth.pixels())
            mm = static_cast<std::uint16_t>(
                std::lround((since_light < unsettled ? 1460 : 1500) + noise(random)));
        ++since_light;
        return Capture::frame;
    };
    Rig rig = cameras.rig();
    const Result<Characteristics> found = characterise(rig, {.seconds = 15}, go_on);
    INFO(refusal(found));
    REQUIRE(found);
    CHECK_FALSE(cameras.lit);
    REQUIRE(found->warm_up);
    CHECK(found->warm_up->cycles == 4); // the first gave what the others are compared with
    CHECK(found->warm_up->unsettled_maps == unsettled);
    CHECK(found->warm_up->settled_ms == Approx(33.0 * (unsettled + 1)));
}

TEST_CASE("noise that neighbours share is told from noise of their own", "[characterise]") {
    FakeCameras cameras;
    std::mt19937 random(1);
    std::normal_distribution<double> own(0, 3), shared(0, 4);
    cameras.read_tof = [&](DepthFrame &frame) {
        if (!cameras.lit || cameras.measured_ns == cameras.t_ns)
            return Capture::none;
        cameras.give_depth(frame);
        const double all = shared(random);
        for (std::uint16_t &mm : frame.depth.pixels())
            mm = static_cast<std::uint16_t>(std::lround(1500 + all + own(random)));
        return Capture::frame;
    };
    Rig rig = cameras.rig();
    const Result<Characteristics> found = characterise(rig, {.seconds = 20, .cycles = 1}, go_on);
    INFO(refusal(found));
    REQUIRE(found);
    CHECK(found->bins.at(0).sigma_m == Approx(0.005).epsilon(0.1));
    CHECK(found->shared_noise == Approx(std::hypot(4.0, 3.0 / 5) / 5).epsilon(0.1));
}

TEST_CASE("a view of one depth scales the configured noise, and the report says so",
          "[characterise]") {
    FakeCameras cameras;
    std::mt19937 random(1);
    const SensorNoise configured;
    std::normal_distribution<double> noise(0, 3000 * configured.sigma(1.5F));
    cameras.read_tof = [&](DepthFrame &frame) {
        if (!cameras.lit || cameras.measured_ns == cameras.t_ns)
            return Capture::none;
        cameras.give_depth(frame);
        for (std::uint16_t &mm : frame.depth.pixels())
            mm = static_cast<std::uint16_t>(std::lround(1500 + noise(random)));
        return Capture::frame;
    };
    Rig rig = cameras.rig();
    const Result<Characteristics> found = characterise(rig, {.seconds = 15, .cycles = 0}, go_on);
    INFO(refusal(found));
    REQUIRE(found);
    CHECK(found->fit.scaled);
    CHECK(curve(found->fit.noise, 3) == Approx(3 * curve(configured, 3)).epsilon(0.1));
    const std::string text = report(*found, Config{});
    CHECK(contains(text, "too little for a curve"));
    CHECK(contains(text, "The light was not switched"));
    CHECK(contains(text, "Too few depth edges"));
}

TEST_CASE("what characterise writes is a configuration", "[characterise]") {
    const Result<Characteristics> found = characterise_room({});
    REQUIRE(found);
    std::string text = report(*found, Config{});
    // A drop-in has no drivers.
    const Result<Config> config =
        parse_config(text.replace(text.find("[tof]"), 5, "[tof]\ndriver = \"synthetic\"") +
                         "[color]\ndriver = \"synthetic\"\n[illuminator]\ndriver = \"synthetic\"\n",
                     "a.toml");
    INFO((config ? text : config.error().message));
    REQUIRE(config);
    CHECK(config->estimator.keyframe.surface.noise.quadratic_per_m ==
          Approx(found->fit.noise.quadratic_per_m).margin(1e-6));
    CHECK(config->estimator.keyframe.error.shared_noise ==
          Approx(found->shared_noise).margin(0.01));
    CHECK(config->tof.warmup_maps == found->warm_up->unsettled_maps + 2);
}

TEST_CASE("characterise says what was missing, and leaves the light dark", "[characterise]") {
    FakeCameras cameras;
    SECTION("no depth maps") {
        cameras.read_tof = [](DepthFrame &) { return Capture::none; };
        Rig rig = cameras.rig();
        CHECK(contains(refusal(characterise(rig, {.seconds = 15}, go_on)),
                       "only 0 settled depth maps came"));
    }
    SECTION("a TOF camera that is lost") {
        cameras.read_tof = [&](DepthFrame &) {
            return cameras.lit ? Capture::lost : Capture::none;
        };
        Rig rig = cameras.rig();
        CHECK(refusal(characterise(rig, {.seconds = 15}, go_on)) == cameras.problem);
    }
    SECTION("a recording that is over too early") {
        int images = 0;
        cameras.read_color = [&](ColorFrame &frame) {
            if (++images > 50)
                return Capture::ended;
            cameras.give_image(frame);
            return Capture::frame;
        };
        Rig rig = cameras.rig();
        CHECK(contains(refusal(characterise(rig, {.seconds = 15, .cycles = 0}, go_on)),
                       "90 are needed"));
    }
    SECTION("a light that does not obey") {
        cameras.light_obeys = Error{"the lamp is broken", 5};
        Rig rig = cameras.rig();
        CHECK(refusal(characterise(rig, {.seconds = 15}, go_on)) == "the lamp is broken");
    }
    SECTION("a person stops it") {
        const std::atomic<bool> stop = true;
        Rig rig = cameras.rig();
        CHECK(refusal(characterise(rig, {.seconds = 15}, stop)) == "stopped before the end");
    }
    CHECK_FALSE(cameras.lit);
    CHECK_FALSE(cameras.color_running);
}

TEST_CASE("a fitted noise curve is one that a sensor can have", "[characterise]") {
    std::vector<DepthBin> bins;
    SECTION("that falls with depth") {
        for (int i = 0; i < 10; ++i)
            bins.push_back(
                {1 + 0.2F * static_cast<float>(i), 0.01F - 0.0008F * static_cast<float>(i), 500});
    }
    SECTION("with one bin that is wrong") {
        for (int i = 0; i < 10; ++i)
            bins.push_back({1 + 0.2F * static_cast<float>(i), 0.003F, 500});
        bins[9].sigma_m = 0.3F;
    }
    SECTION("that bends the wrong way") {
        for (int i = 0; i < 10; ++i)
            bins.push_back({1 + 0.2F * static_cast<float>(i),
                            0.004F + 0.002F * std::sqrt(static_cast<float>(i)), 500});
    }
    const NoiseFit fit = fit_noise(bins, {});
    CHECK(fit.noise.quadratic_per_m >= 0);
    for (float z = 0.5F; z < 5.6F; z += 0.1F)
        CHECK(curve(fit.noise, z) > 0);
    CHECK(curve(fit.noise, 1.8F) == Approx(bins[4].sigma_m).epsilon(0.35));
}
