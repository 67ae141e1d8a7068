// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "drivers/simulated/synthetic/scene.hpp"
#include "drivers/simulated/synthetic/surface.hpp"

#include <cstddef>
#include <vector>

namespace afterglow {

/// What of a scene faces a camera, numbered: the planes, then the balls.
class SurfaceSet {
public:
    /// The scene must outlive it and not change.
    explicit SurfaceSet(const Scene &scene);

    /// The scene as it is at `t_s`, seen by a camera there. Allocates nothing.
    void place(double t_s, const Pose &world_to_camera, const Intrinsics &camera);

    const std::vector<PlaneView> &planes() const { return planes_; }
    const std::vector<BallView> &balls() const { return balls_; }
    std::size_t size() const { return planes_.size() + balls_.size(); }
    /// The plane with that number; null for a ball's.
    const PlaneView *plane(std::size_t index) const {
        return index < planes_.size() ? &planes_[index] : nullptr;
    }
    const BallView &ball(std::size_t index) const { return balls_[index - planes_.size()]; }

    /// As PlaneView and BallView.
    double inverse_z_if_seen(std::size_t index, double u, double v) const {
        return plane(index) != nullptr ? plane(index)->inverse_z_if_seen(u, v)
                                       : ball(index).inverse_z_if_seen(u, v);
    }
    int luma(std::size_t index, double u, double v, float level = 0) const {
        return plane(index) != nullptr ? plane(index)->luma(u, v, level)
                                       : ball(index).luma(u, v, level);
    }

private:
    const Scene &scene_;
    std::vector<PlaneView> planes_; ///< those that face the camera
    std::vector<BallView> balls_;
};

} // namespace afterglow
