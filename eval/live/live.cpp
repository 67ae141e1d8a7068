// SPDX-License-Identifier: Apache-2.0
#include "eval/live/live.hpp"

#include "config/parameter_table.hpp"
#include "core/base/clock.hpp"
#include "drivers/files/image_file.hpp"
#include "eval/dump.hpp"
#include "eval/live/live_picture.hpp"
#include "eval/live/live_scorer.hpp"
#include "eval/live/live_session.hpp"
#include "eval/scoring/footage.hpp"
#include "eval/scoring/summary.hpp"

#include <fmt/format.h>

#include <cerrno>
#include <filesystem>
#include <limits>
#include <tuple>

namespace afterglow {
namespace {

constexpr int frame_timeout_ms = 5000;

/// What the daemon is told; the same words as on this program's command line.
std::string daemon_config(const LiveArguments &arguments, int frames,
                          const std::pair<EstimatorOptions, GatePolicy> &tuning) {
    Config config;
    config.preset = arguments.tuning.preset;
    std::tie(config.estimator, config.gate) = tuning;
    config.daemon.exit_at_end = true;
    config.synthetic.frames = config.replay.frames = frames;
    if (!arguments.replay.empty()) {
        config.color.driver = ColorDriver::replay;
        config.tof.driver = TofDriver::replay;
        config.illuminator.driver = LightDriver::replay;
        config.replay.path = std::filesystem::absolute(arguments.replay);
    }
    return to_toml(config);
}

/// Reads frame `index`, or the newest one where that has been overwritten.
int read_frame(afterglow_stream *stream, std::uint64_t index, LiveFrame &frame) {
    const afterglow_buffer planes[] = {
        {AFTERGLOW_PLANE_DEPTH, 0, frame.depth.pixels().data(), frame.depth.pixels().size_bytes()},
        {AFTERGLOW_PLANE_LUMA, 0, frame.luma.pixels().data(), frame.luma.pixels().size_bytes()},
    };
    const int error = afterglow_read(stream, index, &frame.info, planes, std::size(planes));
    return error == -ESTALE ? afterglow_read_latest(stream, &frame.info, planes, std::size(planes))
                            : error;
}

/// Reads until the daemon has no more, or `frames` have passed, and hands each to the scorer.
/// Returns the frames that went by unread.
Result<std::uint64_t> read_frames(LiveSession &session, int frames, LiveScorer &scorer) {
    afterglow_stream *stream = session.stream();
    afterglow_info info = {};
    info.size = sizeof info;
    afterglow_get_info(stream, &info);
    std::uint64_t next = 0;
    std::uint64_t read = 0;
    while (next < static_cast<std::uint64_t>(frames)) {
        LiveFrame frame(static_cast<int>(info.width), static_cast<int>(info.height));
        int error = read_frame(stream, next, frame);
        if (error == -EAGAIN) {
            error = afterglow_wait(stream, frame_timeout_ms);
            if (error == 0)
                continue;
        }
        if (error == -EPIPE) {
            if (Status over = session.end(); !over)
                return over.error();
            break;
        }
        if (error < 0)
            return Error{fmt::format("reading a frame: {}", afterglow_strerror(error)), -error};
        frame.received_ns = monotonic_ns();
        next = frame.info.index + 1;
        ++read;
        scorer.add(std::move(frame));
    }
    return next - read;
}

void print_summary(const LiveScore &score, const Summary &summary, std::uint64_t unread) {
    const auto line = [](const char *what, const std::string &value) {
        fmt::print("  {:<24}{}\n", what, value);
    };
    const auto percent = [](const std::optional<double> &value) {
        return value ? fmt::format("{:.2f} %", *value) : std::string("-");
    };
    const std::uint64_t published = unread + score.evaluation.frames.size();
    line("frames", fmt::format("{}, {} went by unread", summary.frames, unread));
    if (score.images > published)
        line("images without a frame",
             fmt::format("{}, too fast or unusable", score.images - published));
    line("duty cycle", duty_cycle_text(summary));
    line("error against truth", fmt::format("median MRE {}, 95th percentile {}",
                                            percent(summary.mre_median), percent(summary.mre_p95)));
    line("coverage", fmt::format("median {}", percent(summary.coverage_median)));
    line("image to reader",
         fmt::format("p50 {:.1f} ms, p99 {:.1f} ms", percentile(score.latency_ms, 50).value_or(0),
                     percentile(score.latency_ms, 99).value_or(0)));
    if (summary.unscored > 0)
        line("without readable truth", std::to_string(summary.unscored));
}

} // namespace

void LiveArguments::add_to(CLI::App &command) {
    command.add_option("--replay", replay, "Folder in TUM layout; without it, the synthetic room");
    tuning.add_to(command);
    command.add_option("--frames", frames, "Only the first so many")
        ->check(CLI::Range(1, std::numeric_limits<int>::max()));
    command.add_option("--picture", picture, "Where to put the picture")->capture_default_str();
}

Status live(const LiveArguments &arguments) {
    const auto tuning = arguments.tuning.resolve();
    if (!tuning)
        return tuning.error();
    SyntheticOptions room;
    room.frames = arguments.frames > 0 ? arguments.frames : synthetic_frames;
    auto footage = arguments.replay.empty()
                       ? open_synthetic_footage(room)
                       : open_recorded_footage(arguments.replay, {.frames = arguments.frames});
    if (!footage)
        return footage.error();
    auto session = LiveSession::start(daemon_config(arguments, footage->frames, *tuning));
    if (!session)
        return session.error();
    fmt::print("{}, {} frames in real time, preset {}\n", footage->name, footage->frames,
               arguments.tuning.preset);
    std::fflush(stdout);

    LiveScorer scorer(footage->truth);
    const auto unread = read_frames(*session, footage->frames, scorer);
    if (!unread)
        return unread.error();
    const LiveScore score = scorer.finish();
    if (score.evaluation.frames.empty())
        return Error{"the daemon gave no frame"};
    const Summary summary = summarize(score.evaluation, footage->name, arguments.tuning.preset,
                                      tuning->second.target_mre);
    print_summary(score, summary, *unread);
    if (!score.example) {
        fmt::print("  no picture: nothing was estimated\n");
        return ok();
    }

    const auto folder = std::filesystem::path(arguments.picture).parent_path();
    if (!folder.empty())
        if (Status made = make_folder(folder); !made)
            return made;
    if (Status written = write_png(arguments.picture, live_picture(*score.example)); !written)
        return written;
    fmt::print("{}\n", arguments.picture);
    return ok();
}

} // namespace afterglow
