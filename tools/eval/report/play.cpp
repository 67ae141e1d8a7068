// SPDX-License-Identifier: Apache-2.0
#include "tools/eval/report/play.hpp"

#include "tools/eval/oracle.hpp"

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

std::unique_ptr<DepthSystem> make_player(const SystemDescription &system, const Setting &setting,
                                         const Intrinsics &camera, WorkerPool &pool) {
    const bool keyframes = system.name == "default" || system.name == oracle.name;
    EstimatorOptions options = *estimator_preset(keyframes ? "default" : "paper");
    if (setting.name == "threshold")
        options.ransac.threshold = setting.value;
    if (system.name == oracle.name)
        return std::make_unique<OracleSystem>(options, camera, pool);
    return make_system(system.name, camera, pool, options);
}

GatePolicy make_policy(const SystemDescription &system, const Setting &setting) {
    GatePolicy policy;
    if (system.lighting == Lighting::interval)
        policy.mode = GateMode::interval;
    if (system.lighting == Lighting::never)
        policy.mode = GateMode::off;
    if (setting.name == "interval")
        policy.interval_frames = static_cast<int>(std::lround(setting.value));
    if (setting.name == "target")
        policy.target_mre = setting.value;
    return policy;
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

Player::Player(const SystemDescription &description, const Setting &setting,
               const Intrinsics &camera, WorkerPool &pool)
    : system(make_player(description, setting, camera, pool)),
      gate(make_policy(description, setting)), sees_truth(description.fitted_to_truth) {
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
                               const Setting &setting, WorkerPool &pool, const Watch &watch,
                               const Spectator &spectator) {
    Player player(system, setting, sequence.camera, pool);
    Evaluation evaluation;
    for (const Sequence::Frame &frame : sequence.frames) {
        if (Watch::stopped())
            return std::nullopt;
        FrameScore score;
        const Estimate &estimate = player.step(frame, score.ms);
        score.index = evaluation.frames.size();
        score.t_ns = frame.t_ns;
        score.measured = estimate.source == FrameSource::measured;
        score.age_frames = estimate.age_frames;
        score.inliers = estimate.inliers;
        if (estimate.expected_mre >= 0)
            score.expected_mre = estimate.expected_mre;
        compare(score, estimate.depth, frame.true_depth());
        evaluation.frames.push_back(score);
        if (spectator)
            spectator(static_cast<std::size_t>(score.index), estimate);
        watch.tick();
    }
    return evaluation;
}

} // namespace afterglow
