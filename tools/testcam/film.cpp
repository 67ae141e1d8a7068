// SPDX-License-Identifier: Apache-2.0
#include "tools/testcam/film.hpp"

#include "drivers/replay/recording.hpp"
#include "drivers/replay/replay.hpp"
#include "drivers/sequence_rig.hpp"
#include "drivers/synthetic/synthetic.hpp"
#include "drivers/synthetic/truth.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

namespace afterglow::testcam {
namespace {

class RecordedFilm final : public Film {
public:
    RecordedFilm(Recording recording, double speed)
        : recording_(std::move(recording)), speed_(speed),
          round_ns_(std::llround(static_cast<double>(round_length_ns(recording_)) / speed)) {}

    const Intrinsics &camera() const override { return recording_.camera; }
    double fps() const override {
        return static_cast<double>(recording_.entries.size()) * 1e9 /
               static_cast<double>(round_ns_);
    }
    Frame next(std::int64_t after_ns) const override {
        const std::int64_t round = after_ns / round_ns_ * round_ns_;
        const auto &entries = recording_.entries;
        for (std::uint64_t number = 0; number < entries.size(); ++number)
            if (const std::int64_t due_ns = round + offset_ns(number); due_ns > after_ns)
                return {due_ns, number};
        return {round + round_ns_, 0};
    }
    Status read(std::uint64_t number, ImageView<std::uint16_t> depth) override {
        return read_depth_mm(recording_, number, depth);
    }

private:
    std::int64_t offset_ns(std::uint64_t number) const {
        const auto &entries = recording_.entries;
        return std::llround(
            static_cast<double>(entries[number].t_color_ns - entries[0].t_color_ns) / speed_);
    }

    const Recording recording_;
    const double speed_;
    const std::int64_t round_ns_;
};

class SyntheticFilm final : public Film {
public:
    SyntheticFilm() : camera_(synthetic_camera(options())), truth_(options()) {}

    const Intrinsics &camera() const override { return camera_; }
    double fps() const override { return options().fps; }
    Frame next(std::int64_t after_ns) const override {
        const auto number = static_cast<std::uint64_t>((after_ns - begin_ns_) / period_ns + 1);
        return {begin_ns_ + static_cast<std::int64_t>(number) * period_ns, number};
    }
    Status read(std::uint64_t number, ImageView<std::uint16_t> depth) override {
        const DepthMap truth = truth_.depth(number);
        for (int v = 0; v < depth.height(); ++v)
            std::copy_n(truth.row(v), depth.width(), depth.row(v));
        return ok();
    }

private:
    static constexpr std::int64_t period_ns = 33'333'333;
    static SyntheticOptions options() { return {}; }

    Intrinsics camera_;
    SyntheticTruth truth_;
    const std::int64_t begin_ns_ = MonotonicClock().now_ns();
};

} // namespace

Result<std::unique_ptr<Film>> open_film(const Settings &settings) {
    if (settings.recording.empty())
        return std::unique_ptr<Film>(std::make_unique<SyntheticFilm>());
    Result<Recording> recording = open_recording(settings.recording);
    if (!recording)
        return recording.error();
    return std::unique_ptr<Film>(
        std::make_unique<RecordedFilm>(*std::move(recording), settings.speed));
}

} // namespace afterglow::testcam
