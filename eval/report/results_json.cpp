// SPDX-License-Identifier: Apache-2.0
#include "eval/report/results_json.hpp"

#include "eval/json.hpp"

#include <fmt/format.h>

#include <cerrno>
#include <cstring>
#include <fstream>
#include <nlohmann/json.hpp>
#include <sstream>

namespace afterglow {
namespace {

using nlohmann::json;

std::string as_json(const Score &score) {
    return json_object({{"setting", json_string(score.setting.name)},
                        {"value", json_number(score.setting.value)},
                        {"layout", json_string(score.layout)},
                        {"summary", to_json(score.summary)}});
}

std::string as_json(const Timing &t) {
    return json_object({{"name", json_string(t.name)},
                        {"ms", json_number(t.ms)},
                        {"ratio", json_number(t.ratio)},
                        {"ratio_q1", json_number(t.ratio_q1)},
                        {"ratio_q3", json_number(t.ratio_q3)},
                        {"rounds", std::to_string(t.rounds)}});
}

std::string as_json(const RansacScore &score) {
    return json_object({{"depth", score.depth ? "true" : "false"},
                        {"flow", score.flow ? "true" : "false"},
                        {"plain_rmse_mm", json_number(1000 * score.plain_rmse_m)},
                        {"ransac_rmse_mm", json_number(1000 * score.ransac_rmse_m)},
                        {"reduction", json_number(score.reduction())}});
}

std::string as_json(const Ablation &ablation) {
    return json_object({{"variant", json_string(ablation.variant)},
                        {"shows", json_string(ablation.shows)},
                        {"summary", to_json(ablation.summary)}});
}

std::string as_json(const InfillScore &score) {
    return json_object({{"dataset", json_string(score.dataset)},
                        {"system", json_string(score.system)},
                        {"reason", json_string(score.reason)},
                        {"trials", std::to_string(score.trials)},
                        {"overlap_mre", json_number(score.overlap_mre)},
                        {"filled_mre", json_number(score.filled_mre)},
                        {"filled", json_number(score.filled)}});
}

template <class T>
std::string as_json(const std::vector<T> &values) {
    std::vector<std::string> all;
    for (const T &value : values)
        all.push_back(as_json(value));
    return json_array(all);
}

std::optional<double> number_of(const json &object, const char *key) {
    const auto found = object.find(key);
    return found != object.end() && found->is_number() ? std::optional(found->get<double>())
                                                       : std::nullopt;
}

/// What to_json(Summary) wrote. Throws where a key that must be there is not.
Summary summary_of(const json &object) {
    Summary s;
    s.dataset = object.at("dataset").get<std::string>();
    s.preset = object.at("preset").get<std::string>();
    s.frames = object.at("frames").get<int>();
    s.measured = object.at("measured").get<int>();
    s.duty_cycle = object.at("duty_cycle").get<double>();
    s.damaged = object.value("damaged", 0);
    s.unscored = object.value("unscored", 0);
    s.mre_median = number_of(object, "mre_median");
    s.mre_mean = number_of(object, "mre_mean");
    s.mre_p95 = number_of(object, "mre_p95");
    s.mae_cm_median = number_of(object, "mae_cm_median");
    s.rmse_cm_median = number_of(object, "rmse_cm_median");
    s.coverage_median = number_of(object, "coverage_median");
    s.coverage_p5 = number_of(object, "coverage_p5");
    s.ms_per_frame_median = number_of(object, "ms_per_frame_median");
    s.expected_correlation = number_of(object, "expected_correlation");
    s.frames_over_target = number_of(object, "frames_over_target");
    return s;
}

/// The knob of the job's system, if its settings tell.
Setting setting_of(const json &parameters, const std::string &system) {
    const auto knob = [&](const char *name, const char *key) {
        const auto value = number_of(parameters, key);
        return value ? Setting{name, *value} : Setting{};
    };
    if (parameters.value("gate.mode", "auto") == "interval")
        return knob("interval", "gate.interval_frames");
    return system == "paper" ? knob("threshold", "ransac.threshold")
                             : knob("target", "gate.target_mre");
}

/// What `afterglow-eval run --json` printed.
Score score_of(const json &object) {
    Score score;
    score.summary = summary_of(object);
    if (const auto settings = object.find("settings"); settings != object.end()) {
        score.layout = settings->at("layout").get<std::string>();
        score.setting = setting_of(settings->at("parameters"), score.summary.preset);
    }
    return score;
}

void add_scores(const json &object, std::vector<Score> &scores) {
    if (!object.contains("scores")) {
        scores.push_back(score_of(object));
        return;
    }
    for (const json &written : object.at("scores")) {
        Score &score = scores.emplace_back();
        score.setting.name = written.at("setting").get<std::string>();
        score.setting.value = written.at("value").get<double>();
        score.summary = summary_of(written.at("summary"));
        score.layout = written.at("layout").get<std::string>();
    }
}

} // namespace

std::string to_json(const Results &results) {
    std::vector<std::string> notes;
    for (const std::string &note : results.notes)
        notes.push_back(json_string(note));
    return json_object({{"complete", results.complete ? "true" : "false"},
                        {"notes", json_array(notes)},
                        {"scores", as_json(results.scores)},
                        {"flow_times", as_json(results.flow_times)},
                        {"system_times", as_json(results.system_times)},
                        {"stage_times", as_json(results.stage_times)},
                        {"ransac", as_json(results.ransac)},
                        {"ablations", as_json(results.ablations)},
                        {"infill", as_json(results.infill)}}) +
           "\n";
}

Result<std::vector<Score>> read_scores(const std::string &path) {
    std::ifstream file(path);
    if (!file)
        return Error{fmt::format("{}: {}", path, std::strerror(errno)), errno};
    std::vector<Score> scores;
    try {
        while (file >> std::ws && file.peek() != std::ifstream::traits_type::eof()) {
            json object;
            file >> object;
            add_scores(object, scores);
        }
    } catch (const json::exception &error) {
        return Error{
            fmt::format("{}: not what afterglow-eval run --json prints: {}", path, error.what())};
    }
    if (scores.empty())
        return Error{fmt::format("{}: there is nothing in it", path)};
    return scores;
}

} // namespace afterglow
