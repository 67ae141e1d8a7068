// SPDX-License-Identifier: Apache-2.0
#include "tests/catch.hpp"
#include "eval/scoring/summary.hpp"

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
    frame.measured = true;
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
    CHECK(*summary.mre_median == Approx(2));
    CHECK(*summary.mre_mean == Approx(3));
    CHECK(*summary.mae_cm_median == Approx(4));
    CHECK(*summary.rmse_cm_median == Approx(6));
    CHECK(*summary.coverage_median == Approx(80));
    CHECK(*summary.coverage_p5 == Approx(71));
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

TEST_CASE("the summary's JSON has numbers, and null for missing ones", "[eval]") {
    Evaluation evaluation;
    evaluation.frames = {measured()};
    const std::string json = to_json(summarize(evaluation, "a \"name\"\\\n", "paper", 1.2));
    CHECK(json.rfind("{\"dataset\": \"a \\\"name\\\"\\\\\\u000a\", \"preset\": \"paper\", "
                     "\"frames\": 1, \"measured\": 1, \"duty_cycle\": 100.0000, "
                     "\"mre_median\": null, \"mre_mean\": null, \"mre_p95\": null, "
                     "\"mae_cm_median\": null, \"rmse_cm_median\": null, "
                     "\"coverage_median\": null, \"coverage_p5\": null, "
                     "\"ms_per_frame_median\": 0.0000",
                     0) == 0);
    CHECK(json.find("nan") == std::string::npos);
    CHECK(json.back() == '}');
}
