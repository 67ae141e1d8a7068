// SPDX-License-Identifier: Apache-2.0
#include "drivers/simulated/synthetic/truth.hpp"

#include "drivers/simulated/synthetic/noise.hpp"
#include "drivers/simulated/synthetic/world_camera.hpp"

#include <utility>

namespace afterglow {

struct SyntheticTruth::State {
    State(const SyntheticOptions &options, SyntheticWorld world)
        : camera(options, std::move(world)), exact(0, TofNoise::none()),
          luma(options.width, options.height) {}

    WorldCamera camera;
    Noise exact;
    Luma luma;
};

SyntheticTruth::SyntheticTruth(const SyntheticOptions &options)
    : SyntheticTruth(options, make_world(options)) {}

SyntheticTruth::SyntheticTruth(const SyntheticOptions &options, SyntheticWorld world)
    : state_(std::make_unique<State>(options, std::move(world))) {}

SyntheticTruth::~SyntheticTruth() = default;

SyntheticTruth::SyntheticTruth(SyntheticTruth &&) noexcept = default;

const Intrinsics &SyntheticTruth::intrinsics() const {
    return state_->camera.camera();
}

DepthMap SyntheticTruth::depth(std::uint64_t k) {
    DepthMap depth(intrinsics().width, intrinsics().height);
    const ImageView<const float> z = state_->camera.render(k, state_->luma);
    state_->exact.measure(k, z, state_->luma, depth);
    return depth;
}

Luma SyntheticTruth::luma(std::uint64_t k) {
    state_->camera.render(k, state_->luma);
    return state_->luma;
}

Pose SyntheticTruth::world_to_camera(std::uint64_t k) const {
    return state_->camera.world_to_camera(k);
}

} // namespace afterglow
