// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "core/base/result.hpp"
#include "core/base/rigid_motion.hpp"

#include <Eigen/Geometry>

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

namespace afterglow {

/// Where a camera was, over time: `t tx ty tz qx qy qz qw` a line, seconds and metres, as the TUM
/// benchmark has it.
class Trajectory {
public:
    /// Between two poses further apart in time than this nothing is interpolated.
    static constexpr std::int64_t max_gap_ns = 100'000'000;

    /// Reads such a file. Lines whose time is not later than the one before are left out.
    static Result<Trajectory> read(const std::string &path);

    /// Takes points of the camera's frame to the world's, at time `t_ns`: between two poses,
    /// interpolated. Nothing outside the trajectory and in its gaps.
    std::optional<Pose> camera_to_world(std::int64_t t_ns) const;

    bool empty() const { return poses_.empty(); }

private:
    struct Stamped {
        std::int64_t t_ns;
        Eigen::Quaterniond rotation;
        Eigen::Vector3d position;
    };
    std::vector<Stamped> poses_; // by rising time
};

} // namespace afterglow
