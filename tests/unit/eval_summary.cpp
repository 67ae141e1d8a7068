// SPDX-License-Identifier: Apache-2.0
#include "core/pipeline.hpp"
#include "eval/scoring/summary_json.hpp"
#include "tests/catch.hpp"

#include <fmt/format.h>

using namespace afterglow;

namespace {

FrameScore estimated(double mre, double coverage) {
    FrameScore frame;
    frame.mre = mre;
    frame.coverage = coverage;
    frame.mae_cm = 2 * mre;
    frame.rmse_cm = 3 * mre;
    return frame;
}

FrameScore measured() {
    FrameScore frame = estimated(0, 100);
    frame.measured = frame.lit = true;
    return frame;
}

} // namespace

TEST_CASE("percentiles interpolate between values", "[eval]") {
    CHECK(percentile({3, 1, 2}, 50) == 2);
    CHECK(*percentile({1, 2, 3, 4}, 50) == Approx(2.5));
    CHECK(*percentile({0, 10}, 95) == Approx(9.5));
    CHECK(percentile({7}, 5) == 7);
    CHECK_FALSE(percentile({}, 50));
}

TEST_CASE("the summary's errors and coverage are over estimated frames alone", "[eval]") {
    Evaluation evaluation;
    evaluation.frames = {measured(), estimated(1, 90), estimated(2, 80), estimated(6, 70)};
    const Summary summary = summarize(evaluation, "d", "p", 1.5);
    CHECK(summary.frames == 4);
    CHECK(summary.measured == 1);
    CHECK(summary.duty_cycle == 25);
    CHECK(summary.measured_share == 25);
    CHECK(*summary.mre_median == Approx(2));
    CHECK(*summary.mre_mean == Approx(3));
    CHECK(*summary.mae_cm_median == Approx(4));
    CHECK(*summary.rmse_cm_median == Approx(6));
    CHECK(*summary.coverage_median == Approx(80));
    CHECK(*summary.coverage_p5 == Approx(71));
}

TEST_CASE("the duty cycle counts the frames lit while the TOF camera wakes up", "[eval]") {
    const auto summary_of = [](int wake_latency) {
        auto footage = open_synthetic_footage(
            {.width = 160, .height = 120, .wake_latency_frames = wake_latency, .frames = 40});
        REQUIRE(footage);
        WorkerPool pool(1);
        GatePolicy gate;
        gate.mode = GateMode::interval;
        gate.interval_frames = 10;
        const auto evaluation =
            evaluate(*footage, pipeline_factory(*estimator_preset("default"), pool), gate);
        REQUIRE(evaluation);
        return summarize(*evaluation, "room", "default", gate.target_mre);
    };
    const Summary prompt = summary_of(0);
    CHECK(prompt.measured_share > 0);
    CHECK(prompt.duty_cycle == prompt.measured_share);
    const Summary late = summary_of(3);
    CHECK(late.measured > 0);
    CHECK(late.lit >= 3 * late.measured);
    CHECK(late.duty_cycle == 100.0 * late.lit / 40);
    CHECK(to_text(late).find(fmt::format("lit {:.1f} %, measured {:.1f} %", late.duty_cycle,
                                         late.measured_share)) != std::string::npos);
}

TEST_CASE("the summary counts a frame without depth as zero coverage", "[eval]") {
    Evaluation evaluation;
    FrameScore nothing;
    nothing.coverage = 0;
    evaluation.frames = {estimated(1, 100), nothing};
    const Summary summary = summarize(evaluation, "d", "p", 1.5);
    CHECK(summary.measured == 0);
    CHECK(*summary.mre_median == Approx(1));
    CHECK(*summary.coverage_median == Approx(50));
}

TEST_CASE("the summary correlates expected and true error where both are known", "[eval]") {
    Evaluation evaluation;
    for (double mre : {1.0, 2.0, 4.0}) {
        evaluation.frames.push_back(estimated(mre, 90));
        evaluation.frames.back().expected_mre = 3 * mre + 1;
    }
    CHECK(*summarize(evaluation, "d", "p", 1.5).expected_correlation == Approx(1));
    evaluation.frames[0].expected_mre.reset();
    CHECK_FALSE(summarize(evaluation, "d", "p", 1.5).expected_correlation);
}

namespace {

FrameScore judged(double expected, double actual) {
    FrameScore frame = estimated(actual, 90);
    frame.expected_mre = expected;
    return frame;
}

} // namespace

TEST_CASE("expected errors are compared with true ones from the third measurement on", "[eval]") {
    Evaluation evaluation;
    evaluation.frames = {measured(),   judged(1, 9),   measured(),   judged(1, 9), measured(),
                         judged(1, 1), judged(1, 0.5), judged(2, 4), judged(2, 6), FrameScore{}};
    const Summary s = summarize(evaluation, "d", "p", 1.5);
    REQUIRE(s.true_over_expected);
    CHECK(*s.true_over_expected == Approx(1.5)); // of 0.5, 1, 2, 3
    CHECK(*s.misjudged_share == Approx(50));
    CHECK(expected_against_true(evaluation).true_mre == std::vector<double>{1, 0.5, 4, 6});
}

TEST_CASE("an evaluation of two measurements says nothing of the expected error", "[eval]") {
    Evaluation evaluation;
    evaluation.frames = {measured(), judged(1, 2), measured(), judged(1, 2)};
    const Summary s = summarize(evaluation, "d", "p", 1.5);
    CHECK_FALSE(s.true_over_expected);
    CHECK_FALSE(s.misjudged_share);
}

TEST_CASE("the summary's JSON has numbers, and null for missing ones", "[eval]") {
    Evaluation evaluation;
    evaluation.frames = {measured()};
    const nlohmann::json object = summarize(evaluation, "a \"name\"\\\n", "paper", 1.2);
    CHECK(object.at("dataset") == "a \"name\"\\\n");
    CHECK(object.at("duty_cycle") == 100);
    for (const char *key : {"mre_median", "mre_mean", "mre_p95", "mae_cm_median", "rmse_cm_median",
                            "coverage_median", "coverage_p5"})
        CHECK(object.at(key).is_null());
    const std::string text = json_text(object);
    CHECK(text.find('\n') == std::string::npos);
    CHECK(nlohmann::json::parse(text) == object);
}

TEST_CASE("a summary is the same after it was written as JSON and read", "[eval]") {
    Evaluation evaluation;
    evaluation.frames = {measured(), estimated(1.0 / 3, 90), estimated(2, 80)};
    const nlohmann::json object = summarize(evaluation, "desk", "paper", 1.2);
    const auto again = nlohmann::json::parse(json_text(object)).get<Summary>();
    CHECK(nlohmann::json(again) == object);
    CHECK(again.mre_mean == Approx((1.0 / 3 + 2) / 2));
    CHECK_FALSE(again.expected_correlation);
}

TEST_CASE("JSON text marks bytes of a name that are not UTF-8", "[eval]") {
    CHECK(json_text("d\xffsk \xc3\xa4") == "\"d\xef\xbf\xbdsk \xc3\xa4\"");
}

TEST_CASE("JSON text has null for numbers that are not finite", "[eval]") {
    CHECK(json_text(std::optional(std::nan(""))) == "null");
    CHECK(json_text(std::optional<double>()) == "null");
}
