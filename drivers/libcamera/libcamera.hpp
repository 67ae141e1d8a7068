// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "core/base/camera.hpp"
#include "core/base/result.hpp"
#include "drivers/source.hpp"
#include "drivers/v4l2/list.hpp"

#include <memory>
#include <string>
#include <vector>

namespace afterglow {

// Cameras that libcamera knows: those of boards, which need its pipelines, and USB cameras.
//
// When a camera goes libcamera may spin, wait for ever or abort, and a process can have but one
// CameraManager. So it runs in a process of its own, the program afterglow-libcamera: whatever
// becomes of that, it is killed and begun anew.

struct LibcameraColorOptions {
    std::string device; ///< the camera's id, or a part of it that no other camera's has
    Intrinsics camera;  ///< width and height are asked of the camera, which must have them
    double fps = 30;    ///< asked of cameras that can be; others keep their own rate
    std::string format; ///< as V4l2ColorOptions::format
};

/// The helper's path: beside the running program.
std::string libcamera_helper();

/// An ordinary camera, with the contract of open_v4l2_color(). ColorFrame::t_ns is libcamera's
/// SensorTimestamp; of cameras without, the frame's end set back by a frame.
Result<std::unique_ptr<ColorSource>>
open_libcamera_color(const LibcameraColorOptions &options,
                     const std::string &helper = libcamera_helper());

/// A camera, and its modes that can be read; their rates are not known.
struct LibcameraListing {
    std::string id;
    std::string model;
    std::vector<V4l2Mode> modes;
};
/// Those there are now. Errors: libcamera does not start, or not within five seconds.
Result<std::vector<LibcameraListing>>
list_libcamera_cameras(const std::string &helper = libcamera_helper());

} // namespace afterglow
