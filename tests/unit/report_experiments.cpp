// SPDX-License-Identifier: Apache-2.0
#include "drivers/simulated/synthetic/synthetic.hpp"
#include "drivers/simulated/synthetic/truth.hpp"
#include "eval/ablate.hpp"
#include "eval/experiments/ablation.hpp"
#include "eval/experiments/example.hpp"
#include "eval/experiments/png_data.hpp"
#include "eval/experiments/run_system.hpp"
#include "eval/experiments/tradeoff.hpp"
#include "tests/catch.hpp"
#include "tools/picture/depth_colors.hpp"
#include "tools/picture/error_colors.hpp"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <set>
#include <string>
#include <vector>

using namespace afterglow;

namespace {

constexpr int frames = 8;

/// The synthetic room, small, with a measurement that equals the truth.
Sequence small_room() {
    SyntheticOptions options;
    options.width = 160;
    options.height = 120;
    SyntheticTruth truth(options);
    Sequence sequence{
        .name = "room", .layout = "", .note = "", .camera = truth.intrinsics(), .frames = {}};
    for (std::uint64_t k = 0; k < frames; ++k)
        sequence.frames.push_back(
            {static_cast<std::int64_t>(k) * 33'333'333, truth.luma(k), truth.depth(k), {}});
    return sequence;
}

std::vector<Score> scores_of_sweep(const Sequence &sequence, Sweep how, int workers) {
    Watch watch(1);
    std::vector<Score> scores;
    sweep(sequence, how, workers, watch, [&](Score score) { scores.push_back(std::move(score)); });
    return scores;
}

Score given_score(const char *system, const char *setting, double value) {
    Score score;
    score.setting = {setting, value};
    score.summary.dataset = "room";
    score.summary.preset = system;
    score.summary.duty_cycle = 25;
    score.summary.mre_median = 1;
    return score;
}

} // namespace

TEST_CASE("a sweep's scores and their order do not depend on the number of threads", "[report]") {
    const Sequence room = small_room();
    const auto alone = scores_of_sweep(room, Sweep::adaptive, 1);
    const auto shared = scores_of_sweep(room, Sweep::adaptive, 3);
    REQUIRE(alone.size() == shared.size());
    std::set<std::string> systems;
    for (std::size_t i = 0; i < alone.size(); ++i) {
        CHECK(alone[i].summary.preset == shared[i].summary.preset);
        CHECK(alone[i].setting.value == shared[i].setting.value);
        CHECK(alone[i].summary.mre_median == shared[i].summary.mre_median);
        CHECK(alone[i].summary.frames == frames);
        systems.insert(alone[i].summary.preset);
    }
    CHECK(systems == std::set<std::string>{"paper", "default"});
}

TEST_CASE("a stricter target in a sweep does not lower afterglow's duty cycle", "[report]") {
    std::vector<std::pair<double, double>> duty_cycles; // target, percent
    for (const Score &score : scores_of_sweep(small_room(), Sweep::adaptive, 2))
        if (score.setting.name == "target")
            duty_cycles.emplace_back(score.setting.value, score.summary.duty_cycle);
    std::ranges::sort(duty_cycles);
    REQUIRE(duty_cycles.size() > 3);
    CHECK(duty_cycles.front().second >= duty_cycles.back().second);
    CHECK(preset_score(scores_of_sweep(small_room(), Sweep::adaptive, 2), "room", "default"));
}

TEST_CASE("a sweep's fixed intervals include the one of the compared duty cycle", "[report]") {
    const Sequence room = small_room();
    std::vector<Score> copies, all = scores_of_sweep(room, Sweep::matched, 2);
    std::ranges::copy_if(all, std::back_inserter(copies),
                         [](const Score &score) { return score.summary.preset == "copy"; });
    REQUIRE(copies.size() == 1);
    const double duty_cycle = compared_duty_cycle(all, "room");
    REQUIRE(duty_cycle > 0);
    CHECK(copies[0].setting.name == "interval");
    CHECK(copies[0].setting.value == std::max(2.0, std::round(100 / duty_cycle)));
    const auto expected = std::ceil(frames / copies[0].setting.value);
    CHECK(copies[0].summary.measured == expected);
}

TEST_CASE("an ablation scores every variant, the complete estimator first", "[report]") {
    const Sequence room = small_room();
    Watch watch(1);
    const auto ablations = ablate_sequence(room, 2, watch);
    REQUIRE(ablations.size() == ablation_variants().size());
    for (std::size_t i = 0; i < ablations.size(); ++i) {
        CHECK(ablations[i].variant == ablation_variants()[i].name);
        CHECK(ablations[i].summary.frames == frames);
    }
    const auto scores = scores_of_sweep(room, Sweep::adaptive, 1);
    const Score *complete = preset_score(scores, "room", "default");
    REQUIRE(complete);
    CHECK(ablations[0].summary.mre_median == complete->summary.mre_median);
    CHECK(std::ranges::any_of(ablations, [&](const Ablation &ablation) {
        return ablation.summary.coverage_median != ablations[0].summary.coverage_median;
    }));
}

TEST_CASE("the example shows one frame: its image, its true depth, and each estimate", "[report]") {
    const Sequence room = small_room();
    Watch watch(1);
    const std::vector<Score> scores = {given_score("default", "target", 1.35),
                                       given_score("paper", "threshold", 4)};
    const auto row = example(room, scores, 1, watch);
    REQUIRE(row.size() == 6);
    for (const Picture &picture : row)
        CHECK(picture.group == "room");

    const auto frame = std::ranges::find_if(room.frames, [&](const Sequence::Frame &candidate) {
        return row[1].png ==
               png_data(color_depth(candidate.measured, depth_range(candidate.measured)));
    });
    REQUIRE(frame != room.frames.end());
    const DepthRange range = depth_range(frame->measured);
    CHECK(row[0].colors == Picture::Colors::none);
    for (const std::size_t depth : {1U, 2U, 4U}) {
        CHECK(row[depth].colors == Picture::Colors::depth);
        CHECK(row[depth].from == Approx(range.near_mm / 1000));
        CHECK(row[depth].to == Approx(range.far_mm / 1000));
    }
    CHECK(row[2].caption == "afterglow");
    CHECK(row[3].caption.find(" % off, ") != std::string::npos);
    for (const std::size_t error : {3U, 5U}) {
        CHECK(row[error].colors == Picture::Colors::error);
        CHECK(row[error].to == largest_error_shown);
    }
    // The same frame estimated anew gives the same pictures.
    WorkerPool pool(1);
    const SystemDescription &system = *find_system("default");
    bool compared = false;
    run_system(room, system, tuned(system, scores[0].setting), pool, watch,
               [&](std::size_t index, const Estimate &estimate) {
                   if (index != static_cast<std::size_t>(frame - room.frames.begin()))
                       return;
                   compared = true;
                   CHECK(row[2].png == png_data(color_depth(estimate.depth, range)));
                   CHECK(row[3].png == png_data(color_error(estimate.depth, frame->measured)));
               });
    CHECK(compared);
}

TEST_CASE("a picture in the page is at most 320 pixels wide", "[report]") {
    const auto header = [](char width_high, char width_low, char height) {
        const std::string bytes = std::string("\x89PNG\r\n\x1a\n\0\0\0\rIHDR\0\0", 18) +
                                  width_high + width_low + std::string("\0\0\0", 3) + height;
        return "data:image/png;base64," + base64(bytes);
    };
    CHECK(png_data(Image<Rgb>(320, 9)).starts_with(header(1, 64, 9)));
    CHECK(png_data(Image<Rgb>(640, 9)).starts_with(header(1, 64, 4)));
    CHECK(png_data(Image<Rgb>(16, 9)).starts_with(header(0, 16, 9)));
}
