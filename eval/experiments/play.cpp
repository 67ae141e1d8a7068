// SPDX-License-Identifier: Apache-2.0
#include "eval/experiments/play.hpp"

#include "eval/baselines/oracle.hpp"
#include "eval/run.hpp"

#include <algorithm>
#include <cassert>
#include <chrono>
#include <cmath>
#include <vector>

namespace afterglow {
namespace {

constexpr SystemDescription oracle{.name = "oracle",
                                   .title = "Oracle",
                                   .method = "afterglow with the pose refined on the true depth",
                                   .fitted_to_truth = true};

class OracleSystem final : public DepthSystem {
public:
    OracleSystem(const EstimatorOptions &options, const Intrinsics &camera, WorkerPool &pool)
        : oracle_(options, camera, pool) {}
    void show_truth(DepthView truth) override { truth_ = truth; }
    const Estimate &track(LumaView luma, std::int64_t t_ns) override {
        return oracle_.track(luma, t_ns, truth_);
    }
    const Estimate &measure(DepthView depth) override { return oracle_.measure(depth); }

private:
    Oracle oracle_;
    DepthView truth_;
};

std::unique_ptr<DepthSystem> make_player(const SystemDescription &system,
                                         const EstimatorOptions &options, const Intrinsics &camera,
                                         WorkerPool &pool) {
    if (system.name == oracle.name)
        return std::make_unique<OracleSystem>(options, camera, pool);
    return make_system(system.name, camera, pool, options);
}

/// Made of our pipeline, not of the paper's.
bool is_ours(const SystemDescription &system) {
    return system.name == "default" || system.name == oracle.name;
}

} // namespace

std::span<const SystemDescription> lineup() {
    static const std::vector<SystemDescription> all = [] {
        std::vector<SystemDescription> list(systems().begin(), systems().end());
        list.push_back(oracle);
        return list;
    }();
    return all;
}

const SystemDescription *find_system(std::string_view name) {
    const auto all = lineup();
    const auto found = std::ranges::find(all, name, &SystemDescription::name);
    return found == all.end() ? nullptr : &*found;
}

std::string title_of(std::string_view name) {
    const SystemDescription *system = find_system(name);
    return std::string(system ? system->title : name);
}

Setting own_setting(const SystemDescription &system) {
    if (system.lighting == Lighting::never)
        return {};
    if (system.lighting == Lighting::interval)
        return {"interval", static_cast<double>(GatePolicy().interval_frames)};
    if (system.name == oracle.name)
        return {"target", oracle_target_mre};
    if (is_ours(system))
        return {"target", GatePolicy().target_mre};
    return {"threshold", EstimatorOptions().ransac.threshold};
}

Tuned tuned(const SystemDescription &system, const Setting &setting) {
    Tuned tuned{*estimator_preset(is_ours(system) ? "default" : "paper"), {}};
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

Player::Player(const SystemDescription &description, const Tuned &tuned, const Intrinsics &camera,
               WorkerPool &pool)
    : system(make_player(description, tuned.estimator, camera, pool)), gate(tuned.gate),
      sees_truth(description.fitted_to_truth) {
    assert(system);
}

const Estimate &Player::step(const Sequence::Frame &frame, double &ms) {
    using Clock = std::chrono::steady_clock;
    if (sees_truth)
        system->show_truth(frame.true_depth());
    const auto start = Clock::now();
    const Estimate *estimate = &system->track(frame.luma, frame.t_ns);
    if (gate.wants_light(*estimate)) {
        estimate = &system->measure(frame.measured);
        gate.measured();
    }
    ms = std::chrono::duration<double, std::milli>(Clock::now() - start).count();
    return *estimate;
}

std::optional<Evaluation> play(const Sequence &sequence, const SystemDescription &system,
                               const Tuned &tuned, WorkerPool &pool, Watch &watch,
                               const Spectator &spectator) {
    Player player(system, tuned, sequence.camera, pool);
    Evaluation evaluation;
    for (const Sequence::Frame &frame : sequence.frames) {
        if (Watch::stopped())
            return std::nullopt;
        double ms = 0;
        const Estimate &estimate = player.step(frame, ms);
        const std::size_t index = evaluation.frames.size();
        FrameScore &score =
            evaluation.frames.emplace_back(describe(estimate, index, frame.t_ns, ms));
        compare(score, estimate.depth, frame.true_depth());
        if (spectator)
            spectator(index, estimate);
        watch.tick(work_of(system));
    }
    return evaluation;
}

} // namespace afterglow
