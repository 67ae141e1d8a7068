// SPDX-License-Identifier: Apache-2.0
#include "drivers/simulated/replay.hpp"

#include "drivers/files/image_file.hpp"
#include "drivers/files/recording.hpp"
#include "drivers/simulated/sequence_rig.hpp"
#include "drivers/simulated/synthetic/exposure.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cerrno>
#include <chrono>
#include <cmath>
#include <limits>
#include <string>
#include <utility>

namespace afterglow {
namespace {

constexpr std::int64_t usual_interval_ns = 33'333'333;

class RecordedSequence : public FrameSequence {
public:
    RecordedSequence(Recording recording, bool loop, double exposure_changes)
        : recording_(std::move(recording)), exposure_(1, exposure_changes) {
        const auto &entries = recording_.entries;
        period_ns_ = round_length_ns(recording_);
        // An untrusted file may say that it took centuries: end before time overflows.
        const std::int64_t last_ns = std::numeric_limits<std::int64_t>::max() / 2;
        if (loop)
            last_round_ = static_cast<std::uint64_t>(
                std::max<std::int64_t>(last_ns - entries.back().t_color_ns, 0) / period_ns_);
    }

    const Intrinsics &intrinsics() const override { return recording_.camera; }
    const Intrinsics &tof_intrinsics() const override { return recording_.tof(); }

    std::optional<std::int64_t> time_ns(std::uint64_t k) const override {
        const std::uint64_t round = k / recording_.entries.size();
        if (round > last_round_)
            return std::nullopt;
        return entry(k).t_color_ns + static_cast<std::int64_t>(round) * period_ns_;
    }

    std::int64_t depth_time_ns(std::uint64_t k) const override {
        return *time_ns(k) + entry(k).t_depth_ns - entry(k).t_color_ns;
    }

    Status read_luma(std::uint64_t k, ImageView<std::uint8_t> luma) override {
        const Status read = afterglow::read_luma(entry(k).color_path, luma);
        if (read)
            exposure_.apply(1e-9 * static_cast<double>(*time_ns(k) - *time_ns(0)), luma);
        return read;
    }

    Status read_depth(std::uint64_t k, ImageView<std::uint16_t> depth) override {
        return read_depth_mm(recording_, k % recording_.entries.size(), depth);
    }

private:
    const Recording::Entry &entry(std::uint64_t k) const {
        return recording_.entries[k % recording_.entries.size()];
    }

    Recording recording_;
    Exposure exposure_;
    std::int64_t period_ns_;       ///< from one round's first image to the next's
    std::uint64_t last_round_ = 0; ///< 0: there is no second
};

/// What is wrong with the use of these options for two cameras; empty if nothing is.
std::string problem_with_rig(const ReplayOptions &options) {
    if (!options.rig)
        return "";
    if (options.order.reverse)
        return "a recording of two cameras is not shown backwards: the read-out of its images and "
               "the delay of its depth have a direction";
    if (options.real_time && options.speed != 1)
        return "a recording of two cameras is played at its own speed: the read-out time of its "
               "images and the delay of its depth are in its calibration";
    return "";
}

/// Refuses maps of another camera. One of another size, or that cannot be read, may be an accident.
Status check_map_size(const Recording &recording) {
    const Intrinsics &tof = recording.tof();
    for (const auto *entry : {&recording.entries.front(), &recording.entries.back()}) {
        const auto map = read_grey16(entry->depth_path);
        if (!map || (map->width() == tof.width && map->height() == tof.height))
            return ok();
        if (entry == &recording.entries.back())
            return Error{
                recording.rig
                    ? fmt::format("{}: is {}x{}, but the TOF camera of the calibration has {}x{}",
                                  entry->depth_path, map->width(), map->height(), tof.width,
                                  tof.height)
                    : fmt::format("{}: is {}x{}, but the images are {}x{}: depth that is not "
                                  "registered to them needs the calibration of both cameras, "
                                  "calibration.toml in the folder {}",
                                  entry->depth_path, map->width(), map->height(), tof.width,
                                  tof.height, recording.folder),
                EINVAL};
    }
    return ok();
}

} // namespace

std::int64_t round_length_ns(const Recording &recording) {
    const auto &entries = recording.entries;
    const std::int64_t span = entries.back().t_color_ns - entries.front().t_color_ns;
    const auto intervals = static_cast<std::int64_t>(entries.size()) - 1;
    return span + (intervals > 0 ? span / intervals : usual_interval_ns);
}

Result<Rig> open_replay(const ReplayOptions &options) {
    if (options.wake_latency_frames < 0 || options.frames < 0)
        return Error{"replay: wake_latency_frames and frames may not be negative", EINVAL};
    if (!(options.speed > 0))
        return Error{"replay: the speed must be more than 0", EINVAL};
    if (!(options.exposure_changes >= 0 && options.exposure_changes <= Exposure::most_stops))
        return Error{"replay: exposure_changes must be from 0 to 4 stops", EINVAL};
    if (const std::string problem = problem_with_rig(options); !problem.empty())
        return Error{"replay: " + problem, EINVAL};
    Result<Recording> recording = open_recording(options.path, std::nullopt, options.rig);
    if (!recording)
        return recording.error();
    if (Status fits = check_map_size(*recording); !fits)
        return fits.error();
    reorder(*recording, options.order);
    std::string warning;
    if (recording->skipped > 0)
        warning = fmt::format("{} frames of the recording are left out; the first: {}",
                              recording->skipped, recording->skipped_reason);
    const double round_ns = static_cast<double>(round_length_ns(*recording)) / options.speed;
    Rig rig = make_rig(std::make_unique<RecordedSequence>(*std::move(recording), options.loop,
                                                          options.exposure_changes),
                       {.real_time = options.real_time,
                        .wake_latency_frames = options.wake_latency_frames,
                        .frames = options.frames,
                        .speed = options.speed,
                        .round_ns = options.in_step ? std::llround(round_ns) : 0});
    rig.warning = std::move(warning);
    rig.pairing = pairing_of_delayed(options.rig ? options.rig->tof_delay_s : 0,
                                     std::chrono::nanoseconds(rig_tolerance_ns));
    return rig;
}

} // namespace afterglow
