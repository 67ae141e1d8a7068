// SPDX-License-Identifier: Apache-2.0
#include "eval/experiments/sequence.hpp"

#include "drivers/simulated/sequence_rig.hpp"
#include "drivers/simulated/synthetic/truth.hpp"
#include "eval/datasets/dataset.hpp"
#include "eval/scoring/footage.hpp"
#include "eval/scoring/metrics.hpp"
#include "eval/scoring/summary.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <filesystem>
#include <iterator>
#include <string_view>
#include <utility>

namespace afterglow {
namespace {

constexpr int experiment_frames = 100;

/// How a dataset was filmed, as far as the room can be filmed like it.
struct Filming {
    std::string_view layout; ///< empty: the room as it is
    std::uint64_t seed;      ///< each has its own room
    double fps;
    double motion; ///< relative
    bool noise;
    TofNoise depth;
};

/// Kinect v1: its depth's standard deviation grows with the square of the distance (Khoshelham &
/// Elberink 2012).
constexpr TofNoise kinect_v1{.sigma_at_0 = 0.0005,
                             .sigma_per_square = 0.0015,
                             .nearest = 0.5,
                             .furthest = 5.0,
                             .flying = 0.2};
/// Kinect v2, a TOF camera (Fankhauser et al. 2015).
constexpr TofNoise kinect_v2{.sigma_at_0 = 0.0015,
                             .sigma_per_square = 0.0005,
                             .nearest = 0.5,
                             .furthest = 4.5,
                             .flying = 0.5};

constexpr Filming filmings[] = {
    {"", 1, 30, 1, true, {}},
    {"nyu-v2", 2, 30, 1, true, kinect_v1},
    // A robot that turns abruptly, seen ten times a second.
    {"indoor-rgbd", 3, 10, 1.5, true, kinect_v1},
    {"corbs", 4, 30, 1.5, true, kinect_v2},
    {"icl-nuim", 5, 30, 1, false, {}}, // rendered, without noise
};

std::string source_of(const Filming &filming) {
    return filming.layout.empty() ? synthetic_name
                                  : fmt::format("{}:{}", synthetic_name, filming.layout);
}

Result<Sequence> film_room(const Filming &filming, int frames, Watch &watch) {
    SyntheticOptions options;
    options.real_time = false;
    options.frames = frames > 0 ? frames : experiment_frames;
    options.seed = filming.seed;
    options.fps = filming.fps;
    options.motion = filming.motion;
    options.noise = filming.noise;
    SyntheticWorld world = make_world(options);
    world.tof = filming.depth;
    auto rig = open_synthetic(options, world);
    if (!rig)
        return rig.error();
    SyntheticTruth truth(options, std::move(world));
    Sequence sequence;
    sequence.name = source_of(filming);
    sequence.layout = filming.layout.empty() ? synthetic_name : filming.layout;
    sequence.camera = rig->color->intrinsics();
    for (const Status &done : {rig->color->start(), rig->tof->start(), rig->illuminator->set(true)})
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
        sequence.frames.push_back({color.t_ns, color.luma, depth.depth, truth.depth(color.sequence),
                                   depth.t_ns - color.t_ns});
        watch.tick();
    }
    return sequence;
}

Result<Sequence> load_recording(const std::string &folder, int frames, Watch &watch) {
    auto dataset = open_dataset(folder);
    if (!dataset)
        return dataset.error();
    if (!dataset->calibration.empty())
        return not_registered(folder, dataset->calibration);
    Sequence sequence;
    sequence.name = folder_name(folder);
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
            sequence.frames.push_back({frame.t_ns,
                                       *std::move(luma),
                                       *std::move(depth),
                                       {},
                                       frame.depth_time_ns() - frame.t_ns});
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

class FramesInMemory final : public FrameSequence {
public:
    FramesInMemory(const Sequence &sequence, double repeated_fps)
        : sequence_(sequence), repeated_fps_(repeated_fps) {}
    const Intrinsics &intrinsics() const override { return sequence_.camera; }
    std::optional<std::int64_t> time_ns(std::uint64_t k) const override {
        if (repeated_fps_ > 0)
            return static_cast<std::int64_t>(1e9 / repeated_fps_ * static_cast<double>(k + 1));
        if (k >= sequence_.frames.size())
            return std::nullopt;
        return sequence_.frames[k].t_ns;
    }
    std::int64_t depth_time_ns(std::uint64_t k) const override {
        return *time_ns(k) + frame(k).depth_after_ns;
    }
    Status read_luma(std::uint64_t k, ImageView<std::uint8_t> luma) override {
        return copy(frame(k).luma, luma);
    }
    Status read_depth(std::uint64_t k, ImageView<std::uint16_t> depth) override {
        return copy(frame(k).measured, depth);
    }

private:
    const Sequence::Frame &frame(std::uint64_t k) const {
        return sequence_.frames[k % sequence_.frames.size()];
    }
    template <class Pixel>
    static Status copy(const Image<Pixel> &from, ImageView<Pixel> to) {
        copy_pixels(from, to);
        return ok();
    }

    const Sequence &sequence_;
    double repeated_fps_;
};

} // namespace

Footage footage_of(const Sequence &sequence, double repeated_fps) {
    const auto &frames = sequence.frames;
    return {.name = sequence.name,
            .layout = sequence.layout,
            .rig = make_rig(std::make_unique<FramesInMemory>(sequence, repeated_fps),
                            {.real_time = false}),
            .frames = static_cast<int>(frames.size()),
            .problem = {},
            .assumed = {},
            .truth = [&frames](std::uint64_t k) -> Result<DepthMap> {
                return frames[k % frames.size()].true_depth();
            },
            .sequence_at = [&frames, repeated_fps](std::int64_t t_ns) -> std::uint64_t {
                if (repeated_fps > 0)
                    return static_cast<std::uint64_t>(
                        std::llround(1e-9 * repeated_fps * static_cast<double>(t_ns)) - 1);
                const auto at = std::ranges::lower_bound(frames, t_ns, {}, &Sequence::Frame::t_ns);
                return static_cast<std::uint64_t>(at - frames.begin());
            }};
}

Result<Sequence> load_sequence(const std::string &source, int frames, Watch &watch) {
    const auto *filming = std::ranges::find(filmings, source, source_of);
    const bool synthetic = filming != std::end(filmings) && !std::filesystem::exists(source);
    auto sequence =
        synthetic ? film_room(*filming, frames, watch) : load_recording(source, frames, watch);
    if (sequence && sequence->frames.empty())
        return Error{fmt::format("{}: not one usable frame", source)};
    const auto has_depth = [](const Sequence::Frame &frame) {
        return compare_depth(frame.true_depth(), frame.true_depth()).pixels > 0;
    };
    if (sequence && std::ranges::none_of(sequence->frames, has_depth))
        return no_true_depth(source, sequence->frames.size(), sequence->note);
    return sequence;
}

bool is_stand_in(const std::string &source) {
    const auto *filming = std::ranges::find(filmings, source, source_of);
    return filming != std::end(filmings) && !filming->layout.empty();
}

std::vector<std::string> synthetic_sources() {
    std::vector<std::string> sources;
    for (const Filming &filming : filmings)
        sources.push_back(source_of(filming));
    return sources;
}

} // namespace afterglow
