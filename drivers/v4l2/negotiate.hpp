// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "core/base/camera.hpp"
#include "core/base/result.hpp"
#include "drivers/v4l2/system_calls.hpp"

#include <cstddef>
#include <cstdint>
#include <span>
#include <string>
#include <string_view>
#include <vector>

namespace afterglow::v4l2 {

/// The requested device, size, rate and formats.
struct FormatRequest {
    std::string device;
    int width = 0;
    int height = 0;
    double fps = 0;
    std::span<const std::uint32_t> formats; ///< FourCCs; the first of equal rate is used
};

/// What readers say of a frame with too few bytes.
inline constexpr std::string_view too_short = "it ends too early";

/// The memory layout of a device's frames, and their rate.
struct FrameLayout {
    std::uint32_t buffer_type = 0; ///< V4L2_BUF_TYPE_VIDEO_CAPTURE, or its _MPLANE
    std::uint32_t fourcc = 0;
    int width = 0;
    int height = 0;
    std::size_t stride = 0; ///< bytes from row to row of the first plane
    std::size_t size = 0;   ///< bytes of a frame at most
    std::int64_t period_ns = 0;
};

/// The formats to ask a device for: `known`, or of them the one that the user named ("": none).
/// Refuses a name that is not known, and what no device could satisfy.
Result<std::vector<std::uint32_t>> formats_wanted(const std::string &device,
                                                  const Intrinsics &camera, double fps,
                                                  const std::string &format,
                                                  std::span<const std::uint32_t> known);

/// The buffer type of an open device: V4L2_BUF_TYPE_VIDEO_CAPTURE, or its _MPLANE. Errors: ENODEV,
/// it does not capture.
Result<std::uint32_t> capture_type(SystemCalls &calls, int fd, const std::string &device);
/// The FourCCs that it lists.
std::vector<std::uint32_t> formats_of(SystemCalls &calls, int fd, std::uint32_t type);
/// The highest rate up to the requested one; the requested one where the driver lists none.
double best_rate(SystemCalls &calls, int fd, std::uint32_t fourcc, const FormatRequest &request);

/// Sets format, size and rate of an open device that nobody streams from: the first of the
/// requested formats that the device has at this size and rate; where none is so fast, the
/// fastest. Errors: it does not capture, has no such format or size, or is in use.
Result<FrameLayout> negotiate(SystemCalls &calls, int fd, const FormatRequest &request);

/// Forbids the camera to lower its frame rate in the dark, if it has a control for that.
void forbid_slow_exposure(SystemCalls &calls, int fd);

} // namespace afterglow::v4l2
