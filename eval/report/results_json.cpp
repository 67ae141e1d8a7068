// SPDX-License-Identifier: Apache-2.0
#include "eval/report/results_json.hpp"

#include "eval/scoring/summary_json.hpp"

#include <fmt/format.h>

#include <cerrno>
#include <cstring>
#include <fstream>

namespace afterglow {

using nlohmann::json;

// nlohmann-json finds these by the type of their second argument.

NLOHMANN_DEFINE_TYPE_NON_INTRUSIVE(Timing, name, ms, ratio, ratio_q1, ratio_q3, rounds)
NLOHMANN_DEFINE_TYPE_NON_INTRUSIVE(ExpectedAgainstTrue, expected_mre, true_mre)
NLOHMANN_DEFINE_TYPE_NON_INTRUSIVE(Ablation, variant, shows, summary)
NLOHMANN_DEFINE_TYPE_NON_INTRUSIVE(InfillScore, dataset, system, reason, trials, overlap_mre,
                                   filled_mre, filled)

static void to_json(json &object, const Score &score) {
    object = {{"setting", score.setting.name},
              {"value", score.setting.value},
              {"layout", score.layout},
              {"calibration", score.calibration},
              {"summary", score.summary}};
}

static void from_json(const json &object, Score &score) {
    object.at("setting").get_to(score.setting.name);
    object.at("value").get_to(score.setting.value);
    object.at("layout").get_to(score.layout);
    object.at("summary").get_to(score.summary);
    score.calibration = object.value("calibration", ExpectedAgainstTrue());
}

static void to_json(json &object, const RansacScore &score) {
    object = {{"depth", score.depth},
              {"flow", score.flow},
              {"plain_rmse_mm", 1000 * score.plain_rmse_m},
              {"ransac_rmse_mm", 1000 * score.ransac_rmse_m},
              {"reduction", score.reduction()}};
}

static void from_json(const json &object, RansacScore &score) {
    object.at("depth").get_to(score.depth);
    object.at("flow").get_to(score.flow);
    score.plain_rmse_m = object.at("plain_rmse_mm").get<double>() / 1000;
    score.ransac_rmse_m = object.at("ransac_rmse_mm").get<double>() / 1000;
}

namespace {

/// The parameter that was varied, if the settings of `run --json` tell.
Setting setting_of(const json &parameters, const std::string &system) {
    const auto read = [&](const char *name, const char *key) {
        const auto value = parameters.value(key, std::optional<double>());
        return value ? Setting{name, *value} : Setting{};
    };
    if (parameters.value("gate.mode", "auto") == "interval")
        return read("interval", "gate.interval_frames");
    return system == "paper" ? read("threshold", "ransac.threshold")
                             : read("target", "gate.target_mre");
}

/// What `afterglow-eval run --json` printed.
Score score_of(const json &object) {
    for (const char *key : {"dataset", "preset", "frames", "measured", "duty_cycle"})
        object.at(key); // throws where it is missing
    Score score{.setting = {}, .summary = object.get<Summary>(), .layout = {}};
    if (const auto settings = object.find("settings"); settings != object.end()) {
        settings->at("layout").get_to(score.layout);
        json footage = *settings;
        footage.erase("parameters");
        footage["frames scored"] = score.summary.frames;
        score.footage = footage.dump();
        score.setting = setting_of(settings->at("parameters"), score.summary.preset);
    }
    return score;
}

template <class T>
void append(const json &object, const char *key, std::vector<T> &all) {
    const auto more = object.at(key).get<std::vector<T>>();
    all.insert(all.end(), more.begin(), more.end());
}

bool has_times(const Results &results) {
    return !results.flow_times.empty() || !results.system_times.empty() ||
           !results.stage_times.empty();
}

/// Why a score cannot stand beside another one; "" where it can. Only names tell datasets apart.
std::string conflict_of(const Score &score, const Score &other) {
    const std::string &dataset = score.summary.dataset;
    if (dataset != other.summary.dataset)
        return {};
    if (score.summary.preset == other.summary.preset && score.setting.name == other.setting.name &&
        score.setting.value == other.setting.value)
        return fmt::format(
            "there is a score of '{}' with preset {} and the same setting already, and "
            "nothing else tells scores apart: give folders of different recordings "
            "different names",
            dataset, score.summary.preset);
    if (!score.footage.empty() && !other.footage.empty() && score.footage != other.footage)
        return fmt::format("it is of other frames of '{}' than an earlier file: {} instead of {}",
                           dataset, score.footage, other.footage);
    return {};
}

/// Adds the scores of one file to those of earlier ones. Within a file they are told apart already.
Status add_scores(const std::vector<Score> &scores, Results &results) {
    for (const Score &score : scores)
        for (const Score &other : results.scores)
            if (const std::string conflict = conflict_of(score, other); !conflict.empty())
                return Error{conflict};
    results.scores.insert(results.scores.end(), scores.begin(), scores.end());
    return ok();
}

Status add(const json &object, Results &results) {
    if (!object.contains("scores"))
        return add_scores({score_of(object)}, results);
    results.complete = results.complete && object.at("complete").get<bool>();
    Results timed;
    append(object, "flow_times", timed.flow_times);
    append(object, "system_times", timed.system_times);
    if (object.contains("system_cpu_times")) // results of earlier versions have none
        append(object, "system_cpu_times", timed.system_cpu_times);
    if (object.contains("measured_cpu_times")) // the same
        append(object, "measured_cpu_times", timed.measured_cpu_times);
    append(object, "stage_times", timed.stage_times);
    // Times of different machines cannot be compared: those of one file are kept, with its machine.
    const bool first_times = has_times(timed) && !has_times(results);
    if (first_times) {
        results.flow_times = std::move(timed.flow_times);
        results.system_times = std::move(timed.system_times);
        results.system_cpu_times = std::move(timed.system_cpu_times);
        results.measured_cpu_times = std::move(timed.measured_cpu_times);
        results.stage_times = std::move(timed.stage_times);
    }
    if (first_times || results.version.empty()) {
        results.version = object.value("version", "");
        results.machine = object.value("machine", "");
        results.date = object.value("date", "");
    }
    append(object, "notes", results.notes);
    if (const Status added = add_scores(object.at("scores").get<std::vector<Score>>(), results);
        !added)
        return added;
    if (results.ransac.empty())
        append(object, "ransac", results.ransac);
    append(object, "ablations", results.ablations);
    append(object, "infill", results.infill);
    return ok();
}

} // namespace

std::string to_json(const Results &results) {
    const json object = {{"complete", results.complete},
                         {"version", results.version},
                         {"machine", results.machine},
                         {"date", results.date},
                         {"notes", results.notes},
                         {"scores", results.scores},
                         {"flow_times", results.flow_times},
                         {"system_times", results.system_times},
                         {"system_cpu_times", results.system_cpu_times},
                         {"measured_cpu_times", results.measured_cpu_times},
                         {"stage_times", results.stage_times},
                         {"ransac", results.ransac},
                         {"ablations", results.ablations},
                         {"infill", results.infill}};
    return json_text(object, 1) + "\n";
}

Status read_results(const std::string &path, Results &results) {
    std::ifstream file(path);
    if (!file)
        return Error{fmt::format("{}: {}", path, std::strerror(errno)), errno};
    Results with = results;
    int objects = 0;
    try {
        for (; file >> std::ws && file.peek() != std::ifstream::traits_type::eof(); ++objects) {
            json object;
            file >> object;
            if (const Status added = add(object, with); !added)
                return Error{fmt::format("{}: {}", path, added.error().message)};
        }
    } catch (const json::exception &error) {
        return Error{fmt::format("{}: not what afterglow-eval run --json or report prints: {}",
                                 path, error.what())};
    }
    if (objects == 0)
        return Error{fmt::format("{}: there is nothing in it", path)};
    results = std::move(with);
    return ok();
}

} // namespace afterglow
