// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "core/base/camera.hpp"
#include "core/base/grey.hpp"
#include "core/base/rigid_motion.hpp"
#include "core/calibration/depth_edges.hpp"

#include <Eigen/Core>

#include <array>
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

/// Weights around a place, Gaussian. Made once, looked up to 1/16 pixel.
class EdgeKernel {
public:
    static constexpr int radius = 7, places = 16;

    explicit EdgeKernel(double spread);
    /// Of the pixels -radius .. radius around the one below (place + 1/2) / 16 pixels further.
    const float *at(int place) const { return weights_[static_cast<std::size_t>(place)].data(); }
    int reach() const { return reach_; } ///< weights further off are 0
    float variance() const { return variance_; }

private:
    std::array<std::array<float, 2 * radius + 1>, places> weights_{};
    int reach_;
    float variance_;
};

/// What edges say about a RigError, in pixels of the level. Edges of one tile of the image may
/// share their errors, in one view and from view to view; so the sums are kept by tile.
struct EdgeEvidence {
    static constexpr int columns = 28, rows = 21, tiles = columns * rows;

    Eigen::Matrix<float, 9, 9> H = Eigen::Matrix<float, 9, 9>::Zero(); ///< lower half
    Eigen::Matrix<float, 9, tiles> g = Eigen::Matrix<float, 9, tiles>::Zero();
    /// How much like an edge the image is where the error puts the edges.
    Eigen::Matrix<float, tiles, 1> score = Eigen::Matrix<float, tiles, 1>::Zero();
};

/// The depth edges of one measurement, and how much like an edge the image is along lines across
/// them. Allocates when made; the rest is real-time safe.
class EdgeView {
public:
    /// `camera`: of the images, which are a level of the pyramid.
    EdgeView(const Intrinsics &camera, int capacity);

    /// `edges`: at most the capacity, in the colour camera's frame. `rate`: motion (v, w) of the
    /// scene per second as that camera sees it.
    void take(std::span<const DepthEdge> edges, GreyView image, const Twist &rate);
    /// Looks up the image around where `error` puts the edges, unless it is known there. The calls
    /// below are for errors not far from that.
    void look(const RigError &error);
    int size() const { return static_cast<int>(edges_.size()); }

    /// Adds what the image says around where `error` puts the edges.
    void gather(const RigError &error, const EdgeKernel &kernel, EdgeEvidence &evidence) const;
    /// The i, j = -n .. n for which the image is most like edges where `error` + i `a` + j `b` puts
    /// them; each `every`-th edge is looked at.
    Eigen::Vector2i scan(const RigError &error, const RigError &a, const RigError &b, int n,
                         int every) const;
    /// Squares of the derivatives of the places of edges by the error, their sum.
    const Eigen::Matrix<float, 9, 9> &sensitivity() const { return sensitivity_; }

private:
    static constexpr int reach = 13; ///< pixels of the level
    static constexpr int length = 2 * reach + 1;
    static constexpr int widest_scan = 15;
    using Profile = std::array<float, length>;

    struct Edge {
        Eigen::Vector3f at;
        Eigen::Vector2f across;              ///< unit vector in the image
        Eigen::Matrix<float, 9, 1> by_error; ///< derivative of the place along `across`, pixels
        int tile;
        Profile profile; ///< at whole pixels
    };

    void look_across(Edge &edge) const;

    Intrinsics camera_;
    Image<std::uint8_t> image_;
    std::vector<Edge> edges_;
    Eigen::Matrix<float, 9, 9> sensitivity_ = Eigen::Matrix<float, 9, 9>::Zero();
    RigError base_ = RigError::Zero(); ///< where profiles have their middle
    bool looked_ = false;
};

} // namespace afterglow
