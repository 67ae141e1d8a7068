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
    /// Makes the folder where it is missing. A folder that holds a recording is refused.
    static Result<RecordingWriter> create(const std::string &folder, const Intrinsics &camera);

    /// Adds an image and its depth map, both of the camera's size; `t_ns` rises and is not
    /// negative. What was added stays readable if nothing follows.
    Status add(std::int64_t t_ns, LumaView luma, DepthView depth_mm,
               const std::optional<Pose> &camera_to_world = std::nullopt);

private:
    RecordingWriter(std::string folder, const Intrinsics &camera)
        : folder_(std::move(folder)), camera_(camera) {}

    std::string folder_;
    Intrinsics camera_;
    std::uint64_t count_ = 0;
    std::ofstream associations_;
    std::ofstream ground_truth_;
};

} // namespace afterglow
