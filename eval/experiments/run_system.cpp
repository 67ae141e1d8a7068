// SPDX-License-Identifier: Apache-2.0
#include "eval/experiments/run_system.hpp"

#include "eval/run.hpp"

#include <algorithm>
#include <cassert>
#include <cmath>

namespace afterglow {
namespace {

/// Made of our pipeline, not of the paper's.
bool is_ours(const SystemDescription &system) {
    return system.name == "default" || system.name == oracle_preset;
}

} // namespace

Setting own_setting(const SystemDescription &system) {
    if (system.lighting == Lighting::never)
        return {};
    if (system.lighting == Lighting::interval)
        return {"interval", static_cast<double>(GatePolicy().interval_frames)};
    if (system.name == oracle_preset)
        return {"target", oracle_gate.target_mre};
    if (is_ours(system))
        return {"target", GatePolicy().target_mre};
    return {"threshold", EstimatorOptions().ransac.threshold};
}

Tuned tuned(const SystemDescription &system, const Setting &setting) {
    Tuned tuned{*estimator_preset(is_ours(system) ? "default" : "paper"),
                system.name == oracle_preset ? oracle_gate : GatePolicy{}};
    if (system.lighting == Lighting::interval)
        tuned.gate.mode = GateMode::interval;
    if (system.lighting == Lighting::never)
        tuned.gate.mode = GateMode::off;
    if (setting.name == "threshold")
        tuned.estimator.ransac.threshold = setting.value;
    if (setting.name == "interval")
        tuned.gate.interval_frames = static_cast<int>(std::lround(setting.value));
    if (setting.name == "target")
        tuned.gate.target_mre = setting.value;
    return tuned;
}

int work_of(const SystemDescription &system) {
    struct Work {
        std::string_view name;
        int work;
    };
    constexpr Work slow[] = {{"copy", 20},        {"sfm-sift", 20},    {"sfm-surf", 10},
                             {"sfm-orb", 5},      {"default", 5},      {"oracle", 10},
                             {"opencv-rgbd", 10}, {"reverse-warp", 10}};
    const auto *found = std::ranges::find(slow, system.name, &Work::name);
    return found == std::end(slow) ? 1 : found->work;
}

std::optional<Evaluation> run_system(const Sequence &sequence, const SystemDescription &system,
                                     const Tuned &tuned, WorkerPool &pool, Watch &watch,
                                     const OnEstimate &on_estimate) {
    Footage footage = footage_of(sequence);
    const PipelineFactory make = system_factory(
        system, {.options = tuned.estimator, .pool = pool, .truth = footage.truth_at()});
    const auto evaluation = evaluate(footage, make, tuned.gate,
                                     {.publish =
                                          [&](std::uint64_t index, const Estimate &estimate) {
                                              if (on_estimate)
                                                  on_estimate(index, estimate);
                                              return ok();
                                          },
                                      .progress =
                                          [&](int) {
                                              watch.tick(work_of(system));
                                              return !Watch::stopped();
                                          }});
    assert(evaluation); // frames in memory are always there
    if (Watch::stopped())
        return std::nullopt;
    return *evaluation;
}

} // namespace afterglow
