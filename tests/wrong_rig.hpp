// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "core/base/image.hpp"
#include "core/base/rigid_motion.hpp"
#include "drivers/simulated/synthetic/noise.hpp"
#include "drivers/simulated/synthetic/renderer.hpp"
#include "drivers/simulated/synthetic/synthetic.hpp"

#include <cstdint>
#include <utility>

namespace afterglow::testing {

/// How a TOF camera differs from the colour camera that it is said to equal.
struct Miscalibration {
    Twist color_from_tof = Twist::Zero(); ///< metres, radians
    double focal = 0;                     ///< share by which its focal length is shorter
    double lag_s = 0;                     ///< its maps are exposed so much later
};

/// The synthetic room, seen by a colour camera and a TOF camera that is calibrated wrongly. Both
/// are noisy.
class WrongRig {
public:
    WrongRig(const SyntheticOptions &options, const Miscalibration &wrong)
        : world_(make_world(options)), camera_(synthetic_camera(options)), wrong_(wrong),
          noise_(options.seed, world_.tof), color_(world_.scene, camera_),
          tof_(world_.scene, shorter(camera_, wrong.focal)), unused_(camera_.width, camera_.height),
          luma(camera_.width, camera_.height), depth(camera_.width, camera_.height) {}
    WrongRig(const WrongRig &) = delete; // the renderers hold on to the scene
    WrongRig &operator=(const WrongRig &) = delete;

    /// Both cameras at a time; `frame` chooses the noise.
    void look(double t_s, std::uint64_t frame) {
        color_.render(t_s, world_.camera(t_s).inverse(), luma);
        noise_.add_to(frame, luma);
        const double late = t_s + wrong_.lag_s;
        const Pose world_to_tof =
            afterglow::exp(wrong_.color_from_tof).inverse() * world_.camera(late).inverse();
        tof_.render(late, world_to_tof, unused_);
        noise_.measure(frame, tof_.depth(), unused_, depth);
    }
    /// Metres, as the colour camera sees it, after look().
    ImageView<const float> true_depth() const { return color_.depth(); }
    /// Motion of the scene per second before the colour camera.
    Twist rate(double t_s) const {
        constexpr double dt = 1.0 / 30;
        const Pose now = world_.camera(t_s).inverse(), before = world_.camera(t_s - dt).inverse();
        return afterglow::log(now * before.inverse()) / dt;
    }
    const Intrinsics &camera() const { return camera_; }

private:
    static Intrinsics shorter(Intrinsics camera, double share) {
        camera.fx *= 1 - share;
        camera.fy *= 1 - share;
        return camera;
    }

    SyntheticWorld world_;
    Intrinsics camera_;
    Miscalibration wrong_;
    Noise noise_;
    Renderer color_, tof_;
    Luma unused_;

public:
    Luma luma;
    DepthMap depth;
};

} // namespace afterglow::testing
