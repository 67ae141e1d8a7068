// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "core/base/camera.hpp"
#include "core/base/rigid_motion.hpp"
#include "core/surface/depth_surface.hpp"

#include <Eigen/Core>

#include <span>
#include <vector>

namespace afterglow {

/// A place where a surface ends before one that is further away.
struct DepthEdge {
    Eigen::Vector3f at;     ///< on the near surface's margin, metres
    Eigen::Vector3f beyond; ///< at the same depth, past the margin at right angles to it
};

/// Finds the occlusion edges of a measured surface. Allocates when made; find() is real-time safe.
class DepthEdges {
public:
    /// At most `capacity` edges are found, spread over the whole map.
    explicit DepthEdges(int capacity);

    /// `camera`: the one that the surface is seen by; points are given in the frame to which `pose`
    /// takes that camera's.
    std::span<const DepthEdge> find(const DepthSurface &surface, const Intrinsics &camera,
                                    const Pose &pose);

private:
    std::size_t capacity_;
    std::vector<DepthEdge> edges_; ///< has room for more than capacity_; never grows
};

} // namespace afterglow
