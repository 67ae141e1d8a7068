// SPDX-License-Identifier: Apache-2.0
#include "drivers/simulated/synthetic/truth.hpp"

#include "drivers/simulated/synthetic/lens_renderer.hpp"
#include "drivers/simulated/synthetic/noise.hpp"
#include "drivers/simulated/synthetic/renderer.hpp"

#include <optional>
#include <utility>

namespace afterglow {

struct SyntheticTruth::State {
    State(const SyntheticOptions &options, SyntheticWorld world_)
        : fps(options.fps), rig(synthetic_rig(options)), world(std::move(world_)),
          exact(0, TofNoise::none()) {
        if (!options.rig)
            registered.emplace(world.scene, rig.color.pinhole);
    }

    double time_s(std::uint64_t k) const { return static_cast<double>(k) / fps; }

    /// Its table of rays is kept until another camera is asked for.
    LensRenderer &renderer_of(const CameraModel &camera) {
        if (!lens || lens_camera != camera)
            lens.emplace(world.scene, camera);
        lens_camera = camera;
        return *lens;
    }

    DepthMap in_millimetres(ImageView<const float> z) const {
        const Luma any(z.width(), z.height());
        DepthMap depth(z.width(), z.height());
        exact.measure(0, z, any, depth);
        return depth;
    }

    double fps;
    RigCalibration rig;
    SyntheticWorld world;
    Noise exact;
    std::optional<Renderer> registered; ///< without two cameras
    std::optional<LensRenderer> lens;
    CameraModel lens_camera;
};

SyntheticTruth::SyntheticTruth(const SyntheticOptions &options)
    : SyntheticTruth(options, make_world(options)) {}

SyntheticTruth::SyntheticTruth(const SyntheticOptions &options, SyntheticWorld world)
    : state_(std::make_unique<State>(options, std::move(world))) {}

SyntheticTruth::~SyntheticTruth() = default;

SyntheticTruth::SyntheticTruth(SyntheticTruth &&) noexcept = default;

const Intrinsics &SyntheticTruth::intrinsics() const {
    return state_->rig.color.pinhole;
}

DepthMap SyntheticTruth::depth(std::uint64_t k) {
    if (!state_->registered)
        return depth(k, state_->rig.color, {}, {.readout_s = state_->rig.readout_s});
    Luma luma(intrinsics().width, intrinsics().height);
    state_->registered->render(state_->time_s(k), world_to_camera(k), luma);
    return state_->in_millimetres(state_->registered->depth());
}

DepthMap SyntheticTruth::depth(std::uint64_t k, const CameraModel &camera,
                               const Pose &camera_from_color, const Exposed &exposure) {
    LensRenderer &renderer = state_->renderer_of(camera);
    renderer.render({.body = state_->world.camera,
                     .camera_from_body = camera_from_color,
                     .t_s = state_->time_s(k) + exposure.delay_s,
                     .readout_s = exposure.readout_s},
                    {});
    return state_->in_millimetres(renderer.depth());
}

Luma SyntheticTruth::luma(std::uint64_t k) {
    Luma luma(intrinsics().width, intrinsics().height);
    if (state_->registered)
        state_->registered->render(state_->time_s(k), world_to_camera(k), luma);
    else
        state_->renderer_of(state_->rig.color)
            .render({.body = state_->world.camera,
                     .t_s = state_->time_s(k),
                     .readout_s = state_->rig.readout_s},
                    luma);
    return luma;
}

Pose SyntheticTruth::world_to_camera(std::uint64_t k, double delay_s) const {
    return state_->world.camera(state_->time_s(k) + delay_s).inverse();
}

} // namespace afterglow
