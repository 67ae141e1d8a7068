// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "core/base/camera.hpp"
#include "core/base/rigid_motion.hpp"
#include "core/paper/match.hpp"

#include <random>
#include <vector>

namespace afterglow {

inline const Intrinsics test_camera{525, 525, 319.5, 239.5, 640, 480};

/// Where the point X, in the first camera's frame, is seen before and after the motion.
inline Match exact_match(const Pose &motion, const Eigen::Vector3d &X) {
    return {.from = test_camera.project(X), .to = test_camera.project(motion * X), .z = X.z()};
}

/// `count` points at random pixels and depths from 1 to 4 metres.
inline std::vector<Match> exact_matches(const Pose &motion, int count, unsigned seed = 1) {
    std::mt19937 random(seed);
    std::uniform_real_distribution<double> u(0, 639), v(0, 479), z(1, 4);
    std::vector<Match> matches;
    for (int i = 0; i < count; ++i) {
        const double at_u = u(random);
        const double at_v = v(random);
        matches.push_back(exact_match(motion, test_camera.back_project(at_u, at_v, z(random))));
    }
    return matches;
}

} // namespace afterglow
