// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "core/base/camera.hpp"
#include "core/base/image.hpp"
#include "core/base/result.hpp"
#include "core/base/rigid_motion.hpp"

#include <cstdint>
#include <fstream>
#include <optional>
#include <string>
#include <utility>

namespace afterglow {

/// Writes frames as a folder that open_recording() reads: PNG files, depth in millimetres.
class RecordingWriter {
public:
    /// Makes the folder where it is missing. A folder that holds a recording is refused. `tof`: of
    /// the depth maps, where they are not registered to the images; the caller adds the calibration
    /// (config/calibration_file.hpp).
    static Result<RecordingWriter> create(const std::string &folder, const Intrinsics &camera,
                                          const std::optional<Intrinsics> &tof = std::nullopt);

    /// Adds an image and its depth map, each of its camera's size, with the times of both, which
    /// are not negative; `t_ns` rises. What was added stays readable if nothing follows.
    Status add(std::int64_t t_ns, LumaView luma, std::int64_t t_depth_ns, DepthView depth_mm,
               const std::optional<Pose> &camera_to_world = std::nullopt);
    /// The same with one time for both.
    Status add(std::int64_t t_ns, LumaView luma, DepthView depth_mm,
               const std::optional<Pose> &camera_to_world = std::nullopt) {
        return add(t_ns, luma, t_ns, depth_mm, camera_to_world);
    }

private:
    RecordingWriter(std::string folder, const Intrinsics &camera, const Intrinsics &tof)
        : folder_(std::move(folder)), camera_(camera), tof_(tof) {}

    std::string folder_;
    Intrinsics camera_;
    Intrinsics tof_;
    std::uint64_t count_ = 0;
    std::ofstream associations_;
    std::ofstream ground_truth_;
};

} // namespace afterglow
