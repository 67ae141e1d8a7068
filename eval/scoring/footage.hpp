// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "config/config.hpp"
#include "core/base/image.hpp"
#include "core/base/result.hpp"
#include "core/rig/rig_geometry.hpp"
#include "drivers/files/recording.hpp"
#include "drivers/simulated/synthetic/synthetic.hpp"
#include "drivers/source.hpp"

#include <cstdint>
#include <functional>
#include <optional>
#include <span>
#include <string>
#include <string_view>

namespace afterglow {

/// What stands for the synthetic room where a folder could stand.
inline constexpr const char *synthetic_name = "synthetic";
/// Whether that is the name of the synthetic room, or of one "synthetic:..." that stands in for a
/// dataset.
bool is_synthetic(std::string_view name);

/// The true depth map of an image, millimetres; an error where it cannot be read.
using TruthAt = std::function<Result<DepthMap>(std::int64_t t_ns)>;

/// Frames to evaluate on: the rig that gives them, and what they really show.
struct Footage {
    std::string name;
    std::string layout; ///< of the dataset (docs/datasets.md), or synthetic_name
    Rig rig;
    std::optional<RigGeometry> geometry{}; ///< nothing: depth is registered to the images
    int frames = 0;                        ///< how many there are
    int left_out = 0;                      ///< frames of the recording that cannot be used
    std::string problem;                   ///< the sentence behind the first of those
    std::string assumed; ///< a sentence on what the recording does not say; or empty
    /// By ColorFrame::sequence.
    std::function<Result<DepthMap>(std::uint64_t sequence)> truth;
    /// ColorFrame::sequence of the image with that ColorFrame::t_ns.
    std::function<std::uint64_t(std::int64_t t_ns)> sequence_at;
    /// By ColorFrame::t_ns, for pipelines that see the truth.
    TruthAt truth_at() const {
        return [truth = truth, at = sequence_at](std::int64_t t_ns) { return truth(at(t_ns)); };
    }
};

/// Two cameras of a recording, and which of them is published.
struct RecordedRig {
    std::string calibration{}; ///< a file; empty: calibration.toml in the recording, if it is there
    PublishedCamera published = PublishedCamera::color;
    bool allowed = false; ///< otherwise depth must be registered to the images
};

struct RecordedOptions {
    std::string layout{}; ///< docs/datasets.md; empty: recognised by its files
    int frames = 0;       ///< only the first so many; 0: all
    int wake_latency = 0;
    FrameOrder order{};          ///< in which frames are shown
    double exposure_changes = 0; ///< of images, as in ReplayOptions; stops
    RecordedRig rig{};
};

/// A recording, as fast as it can be read. In another layout than TUM's it is imported into a
/// temporary folder first, which shows its progress and goes with the footage. What stands for the
/// truth is the depth that was recorded with an image; of two cameras, RecordedRigDepth.
Result<Footage> open_recorded_footage(const std::string &folder, const RecordedOptions &options);

/// The synthetic room with a TOF camera other than its own, for "synthetic:noisy" and so on.
struct SimulatedSensor {
    std::string_view name; ///< behind "synthetic:"
    std::string_view shows;
    TofNoise tof;
};
std::span<const SimulatedSensor> simulated_sensors();

/// The TOF camera of "synthetic" or "synthetic:SENSOR"; nothing for any other source.
std::optional<TofNoise> synthetic_tof(std::string_view source);

/// Footage::sequence_at of synthetic cameras that are not in real time.
std::function<std::uint64_t(std::int64_t t_ns)> synthetic_sequence_at(double fps);

/// The synthetic room. `options.frames` bounds it. `source`: one that synthetic_tof() knows.
Result<Footage> open_synthetic_footage(SyntheticOptions options,
                                       const std::string &source = synthetic_name);

} // namespace afterglow
