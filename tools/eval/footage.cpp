// SPDX-License-Identifier: Apache-2.0
#include "tools/eval/footage.hpp"

#include "drivers/replay/recording.hpp"
#include "drivers/replay/replay.hpp"
#include "drivers/synthetic/truth.hpp"

#include <algorithm>
#include <filesystem>
#include <memory>
#include <utility>

namespace afterglow {
namespace {

/// "path/to/name/" and "path/to/name" are both "name".
std::string folder_name(const std::string &folder) {
    const auto path = std::filesystem::absolute(folder).lexically_normal();
    return (path.has_filename() ? path : path.parent_path()).filename();
}

} // namespace

Result<Footage> open_recorded_footage(const std::string &folder, int frames, int wake_latency) {
    auto recording = open_recording(folder);
    if (!recording)
        return recording.error();
    auto rig = open_replay({.path = folder,
                            .real_time = false,
                            .loop = false,
                            .wake_latency_frames = wake_latency,
                            .frames = frames});
    if (!rig)
        return rig.error();
    const auto total = static_cast<int>(recording->entries.size());
    const auto skipped = static_cast<int>(recording->skipped);
    std::string reason = recording->skipped_reason;
    auto shared = std::make_shared<const Recording>(*std::move(recording));
    return Footage{
        .name = folder_name(folder),
        .rig = *std::move(rig),
        .frames = frames > 0 ? std::min(frames, total) : total,
        .left_out = skipped,
        .problem = std::move(reason),
        .truth = [shared](std::uint64_t sequence) -> Result<DepthMap> {
            DepthMap depth(shared->camera.width, shared->camera.height);
            const Status read = read_depth_mm(*shared, sequence, depth);
            if (!read)
                return read.error();
            return depth;
        },
    };
}

Result<Footage> open_synthetic_footage(SyntheticOptions options) {
    options.real_time = false;
    auto rig = open_synthetic(options);
    if (!rig)
        return rig.error();
    auto truth = std::make_shared<SyntheticTruth>(options);
    return Footage{
        .name = "synthetic",
        .rig = *std::move(rig),
        .frames = options.frames,
        .problem = {},
        .truth = [truth](std::uint64_t sequence) -> Result<DepthMap> {
            return truth->depth(sequence);
        },
    };
}

} // namespace afterglow
