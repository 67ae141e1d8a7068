// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "drivers/simulated/synthetic/renderer.hpp"
#include "drivers/simulated/synthetic/synthetic.hpp"

#include <cstdint>
#include <utility>

namespace afterglow {

/// A synthetic world and the camera that moves through it, without sensor noise.
class WorldCamera {
public:
    WorldCamera(const SyntheticOptions &options, SyntheticWorld world)
        : world_(std::move(world)), camera_(synthetic_camera(options)), fps_(options.fps),
          renderer_(world_.scene, camera_) {}
    WorldCamera(const WorldCamera &) = delete; // the renderer holds on to the scene
    WorldCamera &operator=(const WorldCamera &) = delete;

    const Intrinsics &camera() const { return camera_; }
    double time_s(std::uint64_t k) const { return static_cast<double>(k) / fps_; }
    Pose world_to_camera(std::uint64_t k) const { return world_.camera(time_s(k)).inverse(); }

    /// Image k, and its depth in metres until the next call.
    ImageView<const float> render(std::uint64_t k, ImageView<std::uint8_t> luma) {
        renderer_.render(time_s(k), world_to_camera(k), luma);
        return renderer_.depth();
    }

private:
    SyntheticWorld world_;
    Intrinsics camera_;
    double fps_;
    Renderer renderer_;
};

} // namespace afterglow
