// SPDX-License-Identifier: Apache-2.0
#include "drivers/simulated/synthetic/synthetic.hpp"

#include "drivers/simulated/sequence_rig.hpp"
#include "drivers/simulated/synthetic/exposure.hpp"
#include "drivers/simulated/synthetic/renderer.hpp"
#include "drivers/simulated/synthetic/two_cameras.hpp"

#include <algorithm>
#include <cerrno>
#include <cmath>
#include <string>
#include <utility>

namespace afterglow {
namespace {

/// The frames of one camera that depth is registered to.
class SyntheticSequence : public FrameSequence {
public:
    SyntheticSequence(const SyntheticOptions &options, SyntheticWorld world)
        : noise_(options.seed, options.noise ? world.tof : TofNoise::none()),
          lag_frames_(options.noise ? static_cast<std::uint64_t>(world.tof.lag_frames) : 0),
          image_noise_(options.noise), exposure_(options.seed, options.exposure_changes),
          world_(std::move(world)), camera_(synthetic_camera(options)), fps_(options.fps),
          renderer_(world_.scene, camera_), luma_(options.width, options.height) {}
    SyntheticSequence(const SyntheticSequence &) = delete; // the renderer holds on to the scene
    SyntheticSequence &operator=(const SyntheticSequence &) = delete;

    const Intrinsics &intrinsics() const override { return camera_; }

    std::optional<std::int64_t> time_ns(std::uint64_t k) const override {
        return std::llround(time_s(k) * 1e9);
    }

    Status read_luma(std::uint64_t k, ImageView<std::uint8_t> luma) override {
        render(k);
        copy_pixels(luma_, luma);
        exposure_.apply(time_s(k), luma);
        if (image_noise_)
            noise_.add_to(k, luma);
        return ok();
    }

    Status read_depth(std::uint64_t k, ImageView<std::uint16_t> depth) override {
        render(k - std::min(k, lag_frames_));
        noise_.measure(k, renderer_.depth(), luma_, depth);
        return ok();
    }

private:
    double time_s(std::uint64_t k) const { return static_cast<double>(k) / fps_; }

    /// An image and its depth are drawn at once, and most often asked for one after the other.
    void render(std::uint64_t k) {
        if (rendered_ != k)
            renderer_.render(time_s(k), world_.camera(time_s(k)).inverse(), luma_);
        rendered_ = k;
    }

    Noise noise_;
    std::uint64_t lag_frames_;
    bool image_noise_;
    Exposure exposure_;
    SyntheticWorld world_;
    Intrinsics camera_;
    double fps_;
    Renderer renderer_;
    Luma luma_;
    std::optional<std::uint64_t> rendered_;
};

bool has_good_size(const Intrinsics &camera) {
    const auto is_side = [](int side) { return side >= 16 && side <= 4096; };
    return is_side(camera.width) && is_side(camera.height);
}

std::string problem_with(const RigCalibration &rig) {
    if (!has_good_size(rig.color.pinhole) || !has_good_size(rig.tof.pinhole))
        return "rig: width and height of both cameras must be from 16 to 4096";
    for (const CameraModel *camera : {&rig.color, &rig.tof}) {
        const Intrinsics &pinhole = camera->pinhole;
        if (!(pinhole.fx > 0 && pinhole.fy > 0))
            return "rig: focal lengths of both cameras must be greater than 0";
        if (!camera->ray(pinhole.width / 2.0, pinhole.height / 2.0))
            return "rig: both lenses must show something in the middle of the image";
    }
    const Eigen::Matrix3d &R = rig.tof_from_color.R;
    if (!rig.tof_from_color.is_finite() || !(R * R.transpose()).isIdentity(1e-6))
        return "rig: the rotation from the colour camera to the TOF camera must be orthonormal";
    if (!(rig.readout_s >= 0 && rig.readout_s <= 1))
        return "rig: the read-out time must be from 0 to 1 s";
    if (!(std::abs(rig.tof_delay_s) <= 1))
        return "rig: the delay of the TOF camera must be from -1 to 1 s";
    return "";
}

/// What two cameras simulate and one does not, which sees by geometry alone.
bool needs_two_cameras(const SyntheticOptions &options) {
    return options.rig || options.multipath > 0 || options.tof_exposure_ms > 0;
}

/// What is wrong with the options; empty if nothing is.
std::string problem_with(const SyntheticOptions &options) {
    if (!has_good_size(synthetic_camera(options)))
        return "width and height must be from 16 to 4096";
    if (options.rig) {
        if (std::string problem = problem_with(*options.rig); !problem.empty())
            return problem;
    }
    if (!(options.exposure_changes >= 0 && options.exposure_changes <= Exposure::most_stops))
        return "exposure_changes must be from 0 to 4 stops";
    if (!(options.multipath >= 0 && options.multipath <= 10))
        return "multipath must be from 0 to 10";
    if (!(options.tof_exposure_ms >= 0 && options.tof_exposure_ms <= 100))
        return "tof_exposure_ms must be from 0 to 100";
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

RigCalibration synthetic_rig(const SyntheticOptions &options) {
    if (options.rig)
        return *options.rig;
    RigCalibration rig;
    rig.color.pinhole = rig.tof.pinhole = synthetic_camera(options);
    return rig;
}

Result<Rig> open_synthetic(const SyntheticOptions &options) {
    return open_synthetic(options, make_world(options));
}

Result<Rig> open_synthetic(const SyntheticOptions &options, SyntheticWorld world) {
    if (const std::string problem = problem_with(options); !problem.empty())
        return Error{"synthetic: " + problem, EINVAL};
    std::unique_ptr<FrameSequence> sequence;
    if (needs_two_cameras(options))
        sequence = std::make_unique<TwoCameras>(options, std::move(world));
    else
        sequence = std::make_unique<SyntheticSequence>(options, std::move(world));
    Rig rig = make_rig(std::move(sequence), {.real_time = options.real_time,
                                             .wake_latency_frames = options.wake_latency_frames,
                                             .frames = options.frames});
    rig.pairing = pairing_of_delayed(synthetic_rig(options).tof_delay_s, rig.pairing.tolerance);
    return rig;
}

} // namespace afterglow
