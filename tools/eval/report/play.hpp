// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "core/gate.hpp"
#include "tools/eval/evaluation.hpp"
#include "tools/eval/report/results.hpp"
#include "tools/eval/report/sequence.hpp"
#include "tools/eval/rivals/depth_system.hpp"

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
/// As tables print it: "This Work" for "paper". A name that lineup() does not have is its own.
std::string title_of(std::string_view name);

/// A system of lineup(), and who lights the TOF camera for it.
struct Player {
    std::unique_ptr<DepthSystem> system;
    Gate gate;
    bool sees_truth;

    /// With its knob set. `system` must be in lineup(), `setting` one of its own.
    Player(const SystemDescription &system, const Setting &setting, const Intrinsics &camera,
           WorkerPool &pool);
    /// Takes a frame the way of a frame; the time of it goes to `ms`. The estimate that the gate
    /// judged is lost where the frame was measured.
    const Estimate &step(const Sequence::Frame &frame, double &ms);
};

/// Called with each frame's number and what was made of it.
using Spectator = std::function<void(std::size_t index, const Estimate &estimate)>;

/// Shows a system all frames and scores what it makes of them. Nothing when it was stopped.
std::optional<Evaluation> play(const Sequence &sequence, const SystemDescription &system,
                               const Setting &setting, WorkerPool &pool, const Watch &watch,
                               const Spectator &spectator = {});

} // namespace afterglow
