// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "core/gate.hpp"
#include "eval/scoring/evaluation.hpp"
#include "eval/experiments/results.hpp"
#include "eval/experiments/sequence.hpp"
#include "eval/baselines/depth_system.hpp"

#include <functional>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <string_view>

namespace afterglow {

/// All that are compared: systems(), and last the oracle, which sees the truth.
std::span<const SystemDescription> lineup();
/// Of lineup(); nothing for another name.
const SystemDescription *find_system(std::string_view name);
/// As tables print it: "This Work (paper)" for "paper". A name that lineup() does not have is its
/// own.
std::string title_of(std::string_view name);

/// What a system is made with.
struct Tuned {
    EstimatorOptions estimator;
    GatePolicy gate;
};
/// The knob of a system as it comes, not set for any data.
Setting own_setting(const SystemDescription &system);
/// A system of lineup() with its knob set; `setting` is one of its own.
Tuned tuned(const SystemDescription &system, const Setting &setting);

/// What a frame by this system takes, compared with one by the paper's: roughly, for progress bars
/// and to begin with the longest.
int work_of(const SystemDescription &system);

/// A system of lineup(), and who lights the TOF camera for it.
struct Player {
    std::unique_ptr<DepthSystem> system;
    Gate gate;
    bool sees_truth;

    Player(const SystemDescription &system, const Tuned &tuned, const Intrinsics &camera,
           WorkerPool &pool);
    /// Takes a frame the way of a frame; the time of it goes to `ms`. The estimate that the gate
    /// judged is lost where the frame was measured.
    const Estimate &step(const Sequence::Frame &frame, double &ms);
};

/// Called with each frame's number and what was made of it.
using Spectator = std::function<void(std::size_t index, const Estimate &estimate)>;

/// Shows a system all frames and scores what it makes of them. Nothing when it was stopped.
std::optional<Evaluation> play(const Sequence &sequence, const SystemDescription &system,
                               const Tuned &tuned, WorkerPool &pool, Watch &watch,
                               const Spectator &spectator = {});

} // namespace afterglow
