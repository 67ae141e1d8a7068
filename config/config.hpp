// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "core/estimator_options.hpp"
#include "core/gate.hpp"
#include "core/power_model.hpp"
#include "core/result.hpp"
#include "drivers/replay/replay.hpp"
#include "drivers/synthetic/synthetic.hpp"

#include <cstdint>
#include <string>

namespace afterglow {

/// The drivers of this build.
enum class Driver : std::uint8_t { synthetic, replay };

/// What afterglowd is told by its configuration file (config/afterglowd.toml explains each key).
struct Config {
    struct Daemon {
        std::string bus = "system";       ///< "system", "session" or a D-Bus address
        int workers = 2;                  ///< threads that share the estimator's work
        int ring_slots = 8;               ///< frames a reader may be late by
        int realtime_priority = 0;        ///< SCHED_FIFO priority of the estimator thread; 0 = none
        bool run_without_readers = false; ///< keep the cameras on while nobody reads
        bool exit_at_end = false; ///< leave as soon as a recording ends, even while it is read
    } daemon;

    Driver color = Driver::synthetic;
    Driver tof = Driver::synthetic;
    Driver illuminator = Driver::synthetic;
    ReplayOptions replay;
    SyntheticOptions synthetic;

    std::string preset = "default";
    EstimatorOptions estimator; ///< the preset, with the file's overrides
    GatePolicy gate;
    PowerModel power;
};

/// Reads a configuration file. The error's message has one line for each problem:
/// `file:line: key: what is wrong (what is allowed)`. Relative paths in the file are taken from
/// the folder it lies in.
Result<Config> load_config(const std::string &path);

} // namespace afterglow
