// SPDX-License-Identifier: Apache-2.0
#include "tools/eval/report/sequence.hpp"

#include "drivers/synthetic/truth.hpp"
#include "tools/eval/datasets/dataset.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <filesystem>
#include <utility>

namespace afterglow {
namespace {

constexpr const char *synthetic_name = "synthetic";
constexpr int synthetic_frames = 100;

Result<Sequence> film_room(int frames, const Watch &watch) {
    SyntheticOptions options;
    options.real_time = false;
    options.frames = frames > 0 ? frames : synthetic_frames;
    auto rig = open_synthetic(options);
    if (!rig)
        return rig.error();
    SyntheticTruth truth(options);
    Sequence sequence;
    sequence.name = synthetic_name;
    sequence.layout = synthetic_name;
    sequence.camera = rig->color->intrinsics();
    for (Status done : {rig->color->start(), rig->tof->start(), rig->illuminator->set(true)})
        if (!done)
            return done.error();
    const int width = sequence.camera.width;
    const int height = sequence.camera.height;
    ColorFrame color{.luma = Luma(width, height)};
    DepthFrame depth{.depth = DepthMap(width, height)};
    while (!Watch::stopped() &&
           rig->color->read(color, std::chrono::seconds(1)) == Capture::frame) {
        if (rig->tof->read(depth, std::chrono::seconds(1)) != Capture::frame)
            return Error{"the synthetic TOF camera gave no depth"};
        sequence.frames.push_back(
            {color.t_ns, color.luma, depth.depth, truth.depth(color.sequence)});
        watch.tick();
    }
    return sequence;
}

Result<Sequence> load_recording(const std::string &folder, int frames, const Watch &watch) {
    auto dataset = open_dataset(folder);
    if (!dataset)
        return dataset.error();
    const auto path = std::filesystem::absolute(folder).lexically_normal();
    Sequence sequence;
    sequence.name = (path.has_filename() ? path : path.parent_path()).filename();
    sequence.layout = dataset->layout;
    sequence.camera = dataset->camera;
    std::size_t skipped = 0;
    std::string reason;
    for (const Dataset::Frame &frame : dataset->frames) {
        if (Watch::stopped() ||
            (frames > 0 && sequence.frames.size() >= static_cast<std::size_t>(frames)))
            break;
        auto luma = dataset->read_luma(frame.color_path);
        auto depth = dataset->read_depth(frame.depth_path);
        watch.tick();
        if (luma && depth) {
            sequence.frames.push_back({frame.t_ns, *std::move(luma), *std::move(depth), {}});
            continue;
        }
        if (skipped++ == 0)
            reason = luma ? depth.error().message : luma.error().message;
    }
    if (dataset->skipped > 0 && reason.empty())
        reason = dataset->skipped_reason;
    if (skipped + dataset->skipped > 0)
        sequence.note = fmt::format("{}: {} frames were left out; the first: {}", sequence.name,
                                    skipped + dataset->skipped, reason);
    else if (!dataset->assumed.empty())
        sequence.note = fmt::format("{}: {}", sequence.name, dataset->assumed);
    return sequence;
}

} // namespace

Result<Sequence> load_sequence(const std::string &source, int frames, const Watch &watch) {
    const bool synthetic = source == synthetic_name && !std::filesystem::exists(source);
    auto sequence = synthetic ? film_room(frames, watch) : load_recording(source, frames, watch);
    if (sequence && sequence->frames.empty())
        return Error{fmt::format("{}: not one usable frame", source)};
    return sequence;
}

} // namespace afterglow
