// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <libcamera/camera.h>
#include <libcamera/pixel_format.h>
#include <memory>
#include <string>
#include <string_view>
#include <vector>

namespace afterglow::libcam {

/// The configuration that afterglowd asks for.
struct CaptureRequest {
    std::string id;
    int width = 0;
    int height = 0;
    std::int64_t period_us = 0;
    std::vector<std::uint32_t> formats; ///< FourCCs of V4L2, the best first
};

/// Run by the main thread. Each returns when it is done or the other side has closed the socket.
void list_cameras();
void capture(const CaptureRequest &wanted);

/// Any thread.
void say_failed(std::string_view sentence, int code);

libcamera::PixelFormat pixel_format(std::uint32_t v4l2_code);
/// A configuration of one stream, of the first of the requested formats that the camera has at
/// this size. Returns nothing, and says so, if there is none.
std::unique_ptr<libcamera::CameraConfiguration> configuration(libcamera::Camera &camera,
                                                              const CaptureRequest &wanted);

} // namespace afterglow::libcam
