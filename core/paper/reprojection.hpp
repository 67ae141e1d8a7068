// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "core/base/camera.hpp"
#include "core/base/image.hpp"
#include "core/base/rigid_motion.hpp"
#include "core/base/worker_pool.hpp"

#include <vector>

namespace afterglow {

/// Forward reprojection of a depth map (Noraky & Sze 2019, Eq. 7): every pixel's point is moved by
/// the pose and drawn, with its new depth, at the nearest pixel it projects to. Where several fall
/// on one pixel the nearest point wins. Pixels that nothing falls on stay 0.
///
/// The pool's workers share the source rows, each drawing into a buffer of its own; the buffers
/// are merged by minimum, so that the result is the same for any number of workers. warp()
/// allocates nothing.
class ForwardReprojection {
public:
    ForwardReprojection(const Intrinsics &camera, WorkerPool &pool);

    /// `from` and `to`: millimetres, of the camera's size, not overlapping.
    void warp(DepthView from, const Pose &pose, ImageView<std::uint16_t> to);

private:
    void draw_rows(DepthView from, const Pose &pose, int begin, int end, DepthMap &nearest) const;

    Intrinsics camera_;
    WorkerPool &pool_;
    /// One for each worker; holds depth - 1, so that "no depth" is the largest number.
    std::vector<DepthMap> nearest_;
};

} // namespace afterglow
