// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "core/base/result.hpp"
#include "core/estimator_options.hpp"
#include "core/gate.hpp"
#include "eval/scoring/footage.hpp"

#include <CLI/CLI.hpp>

#include <cstdint>
#include <string>
#include <vector>

namespace afterglow {

constexpr int synthetic_frames = 300; ///< unless told otherwise

/// The preset that looks at the truth (oracle.hpp). Only some commands have it; the daemon has not.
inline constexpr const char *oracle_preset = "oracle";
/// Its gate: it lights at a true error above the target, and below the usual coverage_floor.
inline constexpr GatePolicy oracle_gate = {.target_mre = 1.5, .measurement_price = 0};

/// How depth is to be made, as told on a command line.
struct TuningArguments {
    std::string preset = "default";
    std::vector<std::string> assignments; ///< key=value
    bool has_oracle = false;              ///< oracle_preset may be asked for

    void add_to(CLI::App &command);
    /// The preset with the assignments made, or what is wrong with them.
    Result<std::pair<EstimatorOptions, GatePolicy>> resolve() const;
};

/// What opens_synthetic_room() takes, for a person.
std::string synthetic_words();
/// Stands for the synthetic room, and not for a folder of that name.
bool opens_synthetic_room(const std::string &dataset);

/// --frames and --wake-latency, which most commands take.
void add_frame_options(CLI::App &command, int &frames, int &wake_latency);
/// --workers
void add_workers_option(CLI::App &command, int &workers);

/// Which frames there are to score.
struct FootageArguments {
    std::string layout;
    int frames = 0;
    int wake_latency = 0;
    std::uint64_t seed = 1;
    double motion = 1;
    bool noise = true;
    double exposure_changes = 0;
    FrameOrder order{}; ///< of recordings alone
    RecordedRig rig{};  ///< of recordings alone

    void add_to(CLI::App &command);
    /// The options of `rig`, for commands that work on two cameras.
    void add_rig_to(CLI::App &command);
    /// `dataset`: a folder in any known layout, or a source of synthetic_tof(). What had to be
    /// assumed of it is told on standard error.
    Result<Footage> open(const std::string &dataset) const;
};

/// afterglow-eval parameters: lists what `--set` takes with a preset, and the values.
struct ParametersArguments {
    TuningArguments tuning{.assignments = {}, .has_oracle = true};

    void add_to(CLI::App &command) { tuning.add_to(command); }
};

Status list_parameters(const ParametersArguments &arguments);

/// afterglow-eval run: scores one recording, or the synthetic room.
struct RunArguments {
    std::string dataset;
    TuningArguments tuning{.assignments = {}, .has_oracle = true};
    FootageArguments footage;
    int workers = 2;
    int depth_interval_ms = 0;
    bool json = false;
    std::string csv;
    std::string dump;

    void add_to(CLI::App &command);
};

Status run(const RunArguments &arguments);

} // namespace afterglow
