// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "core/base/camera.hpp"
#include "core/base/image.hpp"
#include "core/base/rigid_motion.hpp"
#include "core/keyframe/depth_edges.hpp"

#include <Eigen/Core>

#include <span>
#include <vector>

namespace afterglow {

/// How the two cameras differ from their calibration: a point X of a depth map, brought into the
/// colour camera's frame, belongs at X + t + w x X - lag V there, V being its velocity, and is seen
/// (1 + focal) times as far from the principal point.
/// w (3, radians), t (3, metres), focal (share), lag (seconds), and the pixels of the level by
/// which depth maps show near surfaces too narrow.
using RigError = Eigen::Matrix<double, 9, 1>;
namespace rig_error {
constexpr int turn = 0, displacement = 3, focal = 6, lag = 7, margin = 8;
}

/// How much like an edge the image is along lines across the edges of a view, at whole pixels.
struct EdgeProfiles {
    static constexpr int reach = 13; ///< pixels of the level
    static constexpr int length = 2 * reach + 1;

    explicit EdgeProfiles(int capacity)
        : values(static_cast<std::size_t>(capacity) * static_cast<std::size_t>(length)) {}

    float *of(int edge) { return values.data() + static_cast<std::ptrdiff_t>(edge) * length; }
    const float *of(int edge) const {
        return values.data() + static_cast<std::ptrdiff_t>(edge) * length;
    }

    std::vector<float> values;
};

/// Sums over edges of what they say about a RigError: H x = g.
struct EdgeEvidence {
    Eigen::Matrix<double, 9, 9> H = Eigen::Matrix<double, 9, 9>::Zero();
    RigError g = RigError::Zero();
    double weight = 0, squares = 0; ///< of the offsets
};

/// The depth edges of one measurement and the image that was taken with it. Allocates when made;
/// the rest is real-time safe.
class EdgeView {
public:
    /// `camera`: of the images, which are a level of the pyramid.
    EdgeView(const Intrinsics &camera, int capacity);

    /// `edges`: at most the capacity, in the colour camera's frame. `rate`: motion (v, w) of the
    /// scene per second as that camera sees it.
    void take(std::span<const DepthEdge> edges, ImageView<const float> image, const Twist &rate);
    int size() const { return static_cast<int>(edges_.size()); }
    const Twist &rate() const { return rate_; }

    /// Looks up the image across all edges, placed as with `error`.
    void look(const RigError &error, EdgeProfiles &profiles) const;
    /// Mean of the profiles where `step`, a change of the error, moves the edges; of each
    /// `every`-th.
    double score(const EdgeProfiles &profiles, const RigError &step, int every) const;
    /// Adds what the profiles within some `spread` (pixels, one sigma) of their centre say.
    void gather(const EdgeProfiles &profiles, double spread, EdgeEvidence &evidence) const;
    /// Adds the squares of the derivatives of the places of edges by the error.
    void add_sensitivity(Eigen::Matrix<double, 9, 9> &squares) const;

private:
    struct Edge {
        Eigen::Vector3d at;
        Eigen::Vector2d across; ///< unit vector in the image
        RigError by_error;      ///< derivative of the place along `across`, pixels
    };

    void look_across(const Edge &edge, const RigError &error, float *profile) const;

    Intrinsics camera_;
    Image<std::uint8_t> image_;
    std::vector<Edge> edges_;
    Twist rate_ = Twist::Zero();
};

} // namespace afterglow
