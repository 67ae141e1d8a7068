// SPDX-License-Identifier: Apache-2.0
#include "eval/scoring/footage.hpp"

#include "config/calibration_file.hpp"
#include "core/base/printable.hpp"
#include "drivers/files/recording.hpp"
#include "drivers/simulated/replay.hpp"
#include "drivers/simulated/synthetic/truth.hpp"
#include "eval/datasets/dataset.hpp"
#include "eval/datasets/import.hpp"
#include "eval/import.hpp"
#include "eval/scoring/recorded_rig_depth.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <memory>
#include <utility>

namespace afterglow {
namespace {

/// The cameras of a recording in a folder; nothing: its depth is registered to the images.
/// `source`: its name for a person.
Result<std::optional<RigGeometry>>
recorded_geometry(const std::string &source, const std::string &folder, const RecordedRig &rig) {
    const std::string file =
        rig.calibration.empty() ? calibration_of_recording(folder) : rig.calibration;
    if (file.empty() && rig.published != PublishedCamera::color)
        return Error{fmt::format("{}: is of one camera, whose view is published; another needs the "
                                 "calibration of two",
                                 source),
                     EINVAL};
    if (file.empty())
        return std::optional<RigGeometry>();
    if (!rig.allowed)
        return not_registered(source, file);
    const Result<RigCalibration> calibration = load_calibration(file);
    if (!calibration)
        return calibration.error();
    Config config;
    config.calibration.rig = *calibration;
    config.published.camera = rig.published;
    return rig_geometry(config);
}

} // namespace

Result<Footage> open_recorded_footage(const std::string &source, const RecordedOptions &options) {
    const ImportOptions import{
        .layout = options.layout,
        .frames = options.order == FrameOrder{} ? static_cast<std::size_t>(options.frames) : 0,
        .progress = import_progress()};
    auto prepared = ReplayFolder::prepare(source, import);
    if (!prepared)
        return prepared.error();
    const auto geometry = recorded_geometry(source, prepared->path(), options.rig);
    if (!geometry)
        return geometry.error();
    const std::optional<RigCalibration> cameras =
        *geometry ? std::optional((*geometry)->rig) : std::nullopt;
    auto recording = open_recording(prepared->path(), std::nullopt, cameras);
    if (!recording)
        return recording.error();
    if (static_cast<std::size_t>(options.order.skip) >= recording->entries.size())
        return Error{fmt::format("{}: nothing is left of {} frames when {} are skipped",
                                 printable(source), recording->entries.size(), options.order.skip),
                     EINVAL};
    reorder(*recording, options.order);
    auto rig = open_replay({.path = prepared->path(),
                            .real_time = false,
                            .loop = false,
                            .wake_latency_frames = options.wake_latency,
                            .frames = options.frames,
                            .order = options.order,
                            .exposure_changes = options.exposure_changes,
                            .rig = cameras});
    if (!rig)
        return rig.error();
    const auto total = static_cast<int>(recording->entries.size());
    const ImportSummary &imported = prepared->summary();
    struct Recorded {
        ReplayFolder folder;
        Recording recording;
    };
    Footage footage{
        .name = folder_name(source),
        .layout = imported.layout,
        .rig = *std::move(rig),
        .geometry = *geometry,
        .frames = options.frames > 0 ? std::min(options.frames, total) : total,
        .left_out = static_cast<int>(recording->skipped + imported.skipped),
        .problem = imported.skipped > 0 ? imported.skipped_reason : recording->skipped_reason,
        .assumed = imported.assumed,
        .truth = {},
        .sequence_at = {},
    };
    auto recorded =
        std::make_shared<const Recorded>(Recorded{*std::move(prepared), *std::move(recording)});
    footage.sequence_at = [recorded](std::int64_t t_ns) {
        const auto &entries = recorded->recording.entries;
        const auto at = std::ranges::lower_bound(entries, t_ns, {}, &Recording::Entry::t_color_ns);
        return static_cast<std::uint64_t>(at - entries.begin());
    };
    if (footage.geometry) {
        auto depth = std::make_shared<RecordedRigDepth>(*footage.geometry);
        footage.truth = [recorded, depth](std::uint64_t sequence) {
            return depth->at(recorded->recording, sequence);
        };
        return footage;
    }
    footage.truth = [recorded](std::uint64_t sequence) -> Result<DepthMap> {
        const Intrinsics &camera = recorded->recording.camera;
        DepthMap depth(camera.width, camera.height);
        const Status read = read_depth_mm(recorded->recording, sequence, depth);
        if (!read)
            return read.error();
        return depth;
    };
    return footage;
}

std::span<const SimulatedSensor> simulated_sensors() {
    constexpr TofNoise own;
    static constexpr SimulatedSensor all[] = {
        {"noisy",
         "three times the noise",
         {.sigma_at_0 = 3 * own.sigma_at_0, .sigma_per_square = 3 * own.sigma_per_square}},
        {"biased", "every depth 3 cm too far", {.range_bias = 0.03}},
        {"short-range", "no depth beyond 2.5 m", {.furthest = 2.5}},
        {"late", "depth maps of the image before", {.lag_frames = 1}},
    };
    return all;
}

bool is_synthetic(std::string_view name) {
    const std::string_view room = synthetic_name;
    return name.starts_with(room) && (name == room || name[room.size()] == ':');
}

std::optional<TofNoise> synthetic_tof(std::string_view source) {
    if (source == synthetic_name)
        return TofNoise();
    for (const SimulatedSensor &sensor : simulated_sensors())
        if (source == fmt::format("{}:{}", synthetic_name, sensor.name))
            return sensor.tof;
    return std::nullopt;
}

std::function<std::uint64_t(std::int64_t)> synthetic_sequence_at(double fps) {
    return [fps](std::int64_t t_ns) {
        return static_cast<std::uint64_t>(std::llround(1e-9 * fps * static_cast<double>(t_ns)));
    };
}

Result<Footage> open_synthetic_footage(SyntheticOptions options, const std::string &source) {
    options.real_time = false;
    SyntheticWorld world = make_world(options);
    world.tof = synthetic_tof(source).value();
    auto rig = open_synthetic(options, world);
    if (!rig)
        return rig.error();
    auto truth = std::make_shared<SyntheticTruth>(options, std::move(world));
    return Footage{
        .name = source,
        .layout = synthetic_name,
        .rig = *std::move(rig),
        .frames = options.frames,
        .problem = {},
        .assumed = {},
        .truth = [truth](std::uint64_t sequence) -> Result<DepthMap> {
            return truth->depth(sequence);
        },
        .sequence_at = synthetic_sequence_at(options.fps),
    };
}

} // namespace afterglow
