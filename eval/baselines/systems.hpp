// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "core/pipeline.hpp"
#include "eval/scoring/footage.hpp"

#include <cstdint>
#include <span>
#include <string>
#include <string_view>

namespace afterglow {

/// When a system's TOF camera is lit.
enum class Lighting : std::uint8_t {
    adaptive, ///< when the system asks (Estimate::wants_measurement)
    interval, ///< every so many images
    never,    ///< it has none
};

/// A system that can be made here, and what its figures mean.
struct SystemDescription {
    std::string_view name;   ///< for the command line: "lk"
    std::string_view title;  ///< as the paper's tables print it: "LK"
    std::string_view method; ///< what it is, in a few words
    Lighting lighting = Lighting::adaptive;
    /// It gives depth wherever it has measured, not at keypoints alone.
    bool dense = true;
    /// It sees the true depth of each image: to find the scale of its maps, or as the oracle does.
    bool fitted_to_truth = false;
};

/// All systems, in the order of the paper's tables: "paper" first.
std::span<const SystemDescription> systems();

/// The system with that name; null for a name that systems() does not have.
const SystemDescription *find_system(std::string_view name);
/// As tables print it: "This Work (paper)" for "paper". An unknown name is its own title.
std::string title_of(std::string_view name);

/// What a system may be made of.
struct SystemInputs {
    /// Each system takes what it needs: `flow` and `ransac` those made of the paper's pipeline,
    /// `keyframe` "default" and "oracle". `method` follows from the system.
    EstimatorOptions options;
    WorkerPool &pool; ///< must outlive the system; OpenCV takes one thread
    /// The true depth of an image, for systems with SystemDescription::fitted_to_truth.
    TruthAt truth{};
};

/// Makes the pipeline of a system of systems(). Baselines may allocate in track() and measure().
PipelineFactory system_factory(const SystemDescription &system, const SystemInputs &inputs);

} // namespace afterglow
