// SPDX-License-Identifier: Apache-2.0
//
// afterglow-counted FRAMES PRESET STILL depth|confidence INTERVAL_MS: shows the frames of a file to
// the daemon's frame loop, and then the last image STILL times more with the light off. Marks what
// the pipeline does.
#include "capture/frame_loop.hpp"
#include "drivers/simulated/sequence_rig.hpp"
#include "tools/bench/arm/frames_file.hpp"
#include "tools/bench/arm/marks.hpp"

#include <sys/prctl.h>

#include <algorithm>
#include <cerrno>
#include <cstdio>
#include <cstdlib>
#include <fstream>

using namespace afterglow;
using namespace afterglow::bench;

namespace {

/// The file's frames, and after them the last image again and again.
class FileSequence final : public FrameSequence {
public:
    FileSequence(std::ifstream file, const FramesHeader &header)
        : file_(std::move(file)), header_(header), camera_{header.fx, header.fy,    header.cx,
                                                           header.cy, header.width, header.height} {
    }

    const Intrinsics &intrinsics() const override { return camera_; }
    std::optional<std::int64_t> time_ns(std::uint64_t k) const override {
        const std::uint64_t last = recorded(k);
        return stamp(last) + static_cast<std::int64_t>(k - last) * interval_ns();
    }
    Status read_luma(std::uint64_t k, ImageView<std::uint8_t> luma) override {
        return read(at(recorded(k)) + sizeof(std::int64_t), luma.data(), header_.pixels());
    }
    Status read_depth(std::uint64_t k, ImageView<std::uint16_t> depth) override {
        return read(at(recorded(k)) + sizeof(std::int64_t) + header_.pixels(), depth.data(),
                    2 * header_.pixels());
    }

private:
    std::uint64_t recorded(std::uint64_t k) const {
        return std::min(k, static_cast<std::uint64_t>(header_.frames) - 1);
    }
    std::size_t at(std::uint64_t k) const { return sizeof header_ + k * header_.frame_bytes(); }
    std::int64_t stamp(std::uint64_t k) const {
        std::int64_t t_ns = 0;
        static_cast<void>(read(at(k), &t_ns, sizeof t_ns));
        return t_ns;
    }
    std::int64_t interval_ns() const {
        const auto last = static_cast<std::uint64_t>(header_.frames) - 1;
        return last > 0 ? (stamp(last) - stamp(0)) / static_cast<std::int64_t>(last) : 33'333'333;
    }
    Status read(std::size_t offset, void *to, std::size_t bytes) const {
        file_.seekg(static_cast<std::streamoff>(offset));
        if (!file_.read(static_cast<char *>(to), static_cast<std::streamsize>(bytes)))
            return Error{"the file of frames is too short", EIO};
        return ok();
    }

    mutable std::ifstream file_;
    FramesHeader header_;
    Intrinsics camera_;
};

class MarkedPipeline final : public Pipeline {
public:
    explicit MarkedPipeline(std::unique_ptr<Pipeline> pipeline) : pipeline_(std::move(pipeline)) {}

    const Estimate &track(LumaView luma, std::int64_t t_ns) override {
        mark(Mark::begin);
        const Estimate &estimate = pipeline_->track(luma, t_ns);
        mark(Mark::track);
        ++frame_;
        return estimate;
    }
    const Estimate &measure(const Measurement &measurement) override {
        --frame_;
        mark(Mark::begin);
        const Estimate &estimate = pipeline_->measure(measurement);
        mark(Mark::measure);
        ++frame_;
        return estimate;
    }
    void prepare() override {
        mark(Mark::begin);
        pipeline_->prepare();
        mark(Mark::track);
    }
    void expect_lag(double lag_s) override { pipeline_->expect_lag(lag_s); }
    void restart() override { pipeline_->restart(); }
    void want_confidence(bool wanted) override { pipeline_->want_confidence(wanted); }
    void want_depth(bool wanted) override { pipeline_->want_depth(wanted); }

private:
    void mark(Mark what) const { prctl(mark_option, static_cast<int>(what), frame_); }

    std::unique_ptr<Pipeline> pipeline_;
    long frame_ = 0;
};

int refuse(const char *what) {
    std::fprintf(stderr, "afterglow-counted: %s\n", what);
    return EXIT_FAILURE;
}

} // namespace

int main(int argc, char **argv) {
    if (argc != 6)
        return refuse("the arguments are FRAMES PRESET STILL depth|confidence INTERVAL_MS");
    std::ifstream file(argv[1], std::ios::binary);
    FramesHeader header{};
    if (!file.read(reinterpret_cast<char *>(&header), sizeof header) || header.frames < 1)
        return refuse("there are no frames in the file");
    const auto options = estimator_preset(argv[2]);
    if (!options)
        return refuse("there is no such preset");
    const long frames = static_cast<long>(header.frames);
    const long still = std::strtol(argv[3], nullptr, 10);

    WorkerPool pool(1);
    Rig rig = make_rig(std::make_unique<FileSequence>(std::move(file), header),
                       {.real_time = false, .frames = static_cast<int>(frames + still)});
    const PipelineFactory make = [&](const RigGeometry &geometry) -> std::unique_ptr<Pipeline> {
        return std::make_unique<MarkedPipeline>(pipeline_factory(*options, pool)(geometry));
    };
    FrameLoop loop(rig, make, GatePolicy{});
    loop.want_confidence(std::string_view(argv[4]) == "confidence");
    loop.want_depth_every(std::chrono::milliseconds(std::strtol(argv[5], nullptr, 10)));
    if (!loop.start())
        return refuse("the replay does not start");
    for (long frame = 0; frame < frames + still; ++frame) {
        if (frame == frames)
            loop.gate().set_policy({.mode = GateMode::off});
        const FrameResult result = loop.step(std::chrono::seconds(1));
        if (result.capture != Capture::frame)
            return refuse("a frame cannot be read");
    }
    return EXIT_SUCCESS;
}
