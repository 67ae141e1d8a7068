// SPDX-License-Identifier: Apache-2.0
#include "drivers/simulated/synthetic/synthetic.hpp"

#include "drivers/simulated/sequence_rig.hpp"
#include "drivers/simulated/synthetic/world_camera.hpp"

#include <algorithm>
#include <cerrno>
#include <cmath>
#include <string>
#include <utility>

namespace afterglow {
namespace {

class SyntheticSequence : public FrameSequence {
public:
    SyntheticSequence(const SyntheticOptions &options, SyntheticWorld world)
        : noise_(options.seed, options.noise ? world.tof : TofNoise::none()),
          lag_frames_(options.noise ? static_cast<std::uint64_t>(world.tof.lag_frames) : 0),
          image_noise_(options.noise), camera_(options, std::move(world)),
          luma_(options.width, options.height) {}

    const Intrinsics &intrinsics() const override { return camera_.camera(); }

    std::optional<std::int64_t> time_ns(std::uint64_t k) const override {
        return std::llround(camera_.time_s(k) * 1e9);
    }

    Status read_luma(std::uint64_t k, ImageView<std::uint8_t> luma) override {
        render(k);
        for (int v = 0; v < luma.height(); ++v)
            std::copy_n(luma_.row(v), luma.width(), luma.row(v));
        if (image_noise_)
            noise_.add_to(k, luma);
        return ok();
    }

    Status read_depth(std::uint64_t k, ImageView<std::uint16_t> depth) override {
        render(k - std::min(k, lag_frames_));
        noise_.measure(k, z_, luma_, depth);
        return ok();
    }

private:
    /// An image and its depth are drawn at once, and most often asked for one after the other.
    void render(std::uint64_t k) {
        if (rendered_ != k)
            z_ = camera_.render(k, luma_);
        rendered_ = k;
    }

    Noise noise_;
    std::uint64_t lag_frames_;
    bool image_noise_;
    WorldCamera camera_;
    Luma luma_;
    ImageView<const float> z_;
    std::optional<std::uint64_t> rendered_;
};

/// What is wrong with the options; empty if nothing is.
std::string problem_with(const SyntheticOptions &options) {
    const auto is_side = [](int side) { return side >= 16 && side <= 4096; };
    if (!is_side(options.width) || !is_side(options.height))
        return "width and height must be from 16 to 4096";
    if (!(options.fps >= 0.1 && options.fps <= 1000))
        return "fps must be from 0.1 to 1000";
    if (options.wake_latency_frames < 0 || options.frames < 0)
        return "wake_latency_frames and frames may not be negative";
    if (!(options.motion >= 0 && options.motion <= 100))
        return "motion must be from 0 to 100";
    return "";
}

} // namespace

SyntheticWorld make_world(const SyntheticOptions &options) {
    return {.scene = make_room(options.seed),
            .camera = hand_held(options.seed, options.motion),
            .tof = {}};
}

Intrinsics synthetic_camera(const SyntheticOptions &options) {
    const double f = 525.0 * options.width / 640;
    return {
        f, f, (options.width - 1) / 2.0, (options.height - 1) / 2.0, options.width, options.height};
}

Result<Rig> open_synthetic(const SyntheticOptions &options) {
    return open_synthetic(options, make_world(options));
}

Result<Rig> open_synthetic(const SyntheticOptions &options, SyntheticWorld world) {
    if (const std::string problem = problem_with(options); !problem.empty())
        return Error{"synthetic: " + problem, EINVAL};
    return make_rig(std::make_unique<SyntheticSequence>(options, std::move(world)),
                    {.real_time = options.real_time,
                     .wake_latency_frames = options.wake_latency_frames,
                     .frames = options.frames});
}

} // namespace afterglow
