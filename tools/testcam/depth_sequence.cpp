// SPDX-License-Identifier: Apache-2.0
#include "tools/testcam/depth_sequence.hpp"

#include "core/base/clock.hpp"
#include "drivers/files/recording.hpp"
#include "drivers/simulated/sequence_rig.hpp"
#include "drivers/simulated/synthetic/synthetic.hpp"
#include "drivers/simulated/synthetic/truth.hpp"

#include <algorithm>
#include <utility>

namespace afterglow::testcam {
namespace {

class RecordedDepth final : public DepthSequence {
public:
    RecordedDepth(Recording recording, double speed)
        : recording_(std::move(recording)), rounds_(recording_, speed) {}

    const Intrinsics &camera() const override { return recording_.camera; }
    double fps() const override {
        return static_cast<double>(recording_.entries.size()) * 1e9 /
               static_cast<double>(rounds_.length_ns());
    }
    Rounds::Frame next(std::int64_t after_ns) const override { return rounds_.next(after_ns); }
    Status read(std::uint64_t number, ImageView<std::uint16_t> depth) override {
        return read_depth_mm(recording_, number, depth);
    }

private:
    const Recording recording_;
    const Rounds rounds_;
};

class SyntheticDepth final : public DepthSequence {
public:
    SyntheticDepth() : camera_(synthetic_camera(options())), truth_(options()) {}

    const Intrinsics &camera() const override { return camera_; }
    double fps() const override { return options().fps; }
    Rounds::Frame next(std::int64_t after_ns) const override {
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
    const std::int64_t begin_ns_ = monotonic_ns();
};

} // namespace

Result<std::unique_ptr<DepthSequence>> open_depth_sequence(const Settings &settings) {
    if (settings.recording.empty())
        return std::unique_ptr<DepthSequence>(std::make_unique<SyntheticDepth>());
    Result<Recording> recording = open_recording(settings.recording);
    if (!recording)
        return recording.error();
    return std::unique_ptr<DepthSequence>(
        std::make_unique<RecordedDepth>(*std::move(recording), settings.speed));
}

} // namespace afterglow::testcam
