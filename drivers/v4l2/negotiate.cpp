// SPDX-License-Identifier: Apache-2.0
#include "drivers/v4l2/negotiate.hpp"

#include "core/base/printable.hpp"
#include "drivers/frame_rate.hpp"
#include "drivers/v4l2/device.hpp"

#include <fmt/format.h>
#include <linux/videodev2.h>

#include <algorithm>
#include <cerrno>
#include <cmath>
#include <vector>

namespace afterglow::v4l2 {
namespace {

double rate_of(const v4l2_fract &period) {
    return period.numerator == 0 ? 0 : static_cast<double>(period.denominator) / period.numerator;
}

bool is_step(std::uint32_t value, std::uint32_t least, std::uint32_t most, std::uint32_t step) {
    return value >= least && value <= most && (value - least) % std::max(step, 1U) == 0;
}

/// Whether frames of the requested size exist in this format. A driver that cannot list its
/// sizes is asked for one when the format is set.
bool has_size(SystemCalls &calls, int fd, std::uint32_t fourcc, const FormatRequest &request) {
    const auto w = static_cast<std::uint32_t>(request.width);
    const auto h = static_cast<std::uint32_t>(request.height);
    v4l2_frmsizeenum size = {};
    size.pixel_format = fourcc;
    for (; calls.ioctl(fd, VIDIOC_ENUM_FRAMESIZES, &size) == 0; ++size.index) {
        if (size.type != V4L2_FRMSIZE_TYPE_DISCRETE) {
            const v4l2_frmsize_stepwise &range = size.stepwise;
            return is_step(w, range.min_width, range.max_width, range.step_width) &&
                   is_step(h, range.min_height, range.max_height, range.step_height);
        }
        if (size.discrete.width == w && size.discrete.height == h)
            return true;
    }
    return size.index == 0;
}

/// 0 where no format will do.
std::uint32_t choose(SystemCalls &calls, int fd, const std::vector<std::uint32_t> &offered,
                     const FormatRequest &request) {
    std::uint32_t chosen = 0;
    double fastest = 0;
    for (const std::uint32_t fourcc : request.formats) {
        if (!contains(offered, fourcc) || !has_size(calls, fd, fourcc, request))
            continue;
        const double rate = best_rate(calls, fd, fourcc, request);
        if (is_as_fast(rate, request.fps))
            return fourcc;
        if (rate > fastest) {
            fastest = rate;
            chosen = fourcc;
        }
    }
    return chosen;
}

Error no_format(const std::vector<std::uint32_t> &offered, const FormatRequest &request) {
    std::string names;
    for (const std::uint32_t fourcc : offered)
        names += (names.empty() ? "" : ", ") + to_string(fourcc);
    return {fmt::format("the camera '{}' has no usable format of {}x{} (it offers {})",
                        printable(request.device), request.width, request.height,
                        names.empty() ? "none" : names),
            EINVAL};
}

Result<FrameLayout> set_format(SystemCalls &calls, int fd, std::uint32_t type, std::uint32_t fourcc,
                               const FormatRequest &request) {
    const bool planes = type == V4L2_BUF_TYPE_VIDEO_CAPTURE_MPLANE;
    v4l2_format format = {};
    format.type = type;
    // The first four fields of pix and pix_mp are the same: width, height, format, field.
    format.fmt.pix.width = static_cast<std::uint32_t>(request.width);
    format.fmt.pix.height = static_cast<std::uint32_t>(request.height);
    format.fmt.pix.pixelformat = fourcc;
    format.fmt.pix.field = V4L2_FIELD_NONE;
    if (calls.ioctl(fd, VIDIOC_S_FMT, &format) != 0)
        return device_error(request.device, "set the format", errno);

    const v4l2_pix_format &got = format.fmt.pix;
    if (got.pixelformat != fourcc || got.width != static_cast<std::uint32_t>(request.width) ||
        got.height != static_cast<std::uint32_t>(request.height))
        return Error{fmt::format("the camera '{}' gives {} of {}x{} instead of {} of {}x{}",
                                 printable(request.device), to_string(got.pixelformat), got.width,
                                 got.height, to_string(fourcc), request.width, request.height),
                     EINVAL};
    if (got.field != V4L2_FIELD_NONE && got.field != V4L2_FIELD_ANY)
        return Error{
            fmt::format("the camera '{}' gives interlaced images", printable(request.device)),
            EINVAL};

    FrameLayout layout;
    layout.buffer_type = type;
    layout.fourcc = fourcc;
    layout.width = request.width;
    layout.height = request.height;
    layout.stride = planes ? format.fmt.pix_mp.plane_fmt[0].bytesperline : got.bytesperline;
    layout.size = planes ? format.fmt.pix_mp.plane_fmt[0].sizeimage : got.sizeimage;
    return layout;
}

std::int64_t set_rate(SystemCalls &calls, int fd, std::uint32_t type, double fps) {
    v4l2_streamparm rate = {};
    rate.type = type;
    rate.parm.capture.timeperframe = {1000, static_cast<std::uint32_t>(std::lround(fps * 1000))};
    double got = 0;
    if (calls.ioctl(fd, VIDIOC_S_PARM, &rate) == 0)
        got = rate_of(rate.parm.capture.timeperframe);
    return std::llround(1e9 / (got > 0 ? got : fps));
}

} // namespace

Result<std::vector<std::uint32_t>> formats_wanted(const std::string &device,
                                                  const Intrinsics &camera, double fps,
                                                  const std::string &format,
                                                  std::span<const std::uint32_t> known) {
    if (device.empty())
        return Error{"no camera is named", 0};
    if (camera.width < 1 || camera.height < 1 || !(camera.fx > 0) || !(camera.fy > 0))
        return Error{fmt::format("the size and focal lengths of '{}' must be more than 0",
                                 printable(device)),
                     0};
    if (!(fps > 0 && fps <= 1000))
        return Error{fmt::format("{:g} frames a second are not possible", fps), 0};
    if (format.empty())
        return std::vector<std::uint32_t>(known.begin(), known.end());
    const auto named = std::find(known.begin(), known.end(), fourcc_from_string(format));
    if (named == known.end())
        return Error{fmt::format("the format '{}' is not one that can be read", printable(format)),
                     0};
    return std::vector<std::uint32_t>{*named};
}

Result<std::uint32_t> capture_type(SystemCalls &calls, int fd, const std::string &device) {
    v4l2_capability about = {};
    if (calls.ioctl(fd, VIDIOC_QUERYCAP, &about) != 0)
        return device_error(device, "say what it is", errno);
    const std::uint32_t can = capabilities(about);
    if ((can & V4L2_CAP_STREAMING) != 0 && (can & V4L2_CAP_VIDEO_CAPTURE) != 0)
        return static_cast<std::uint32_t>(V4L2_BUF_TYPE_VIDEO_CAPTURE);
    if ((can & V4L2_CAP_STREAMING) != 0 && (can & V4L2_CAP_VIDEO_CAPTURE_MPLANE) != 0)
        return static_cast<std::uint32_t>(V4L2_BUF_TYPE_VIDEO_CAPTURE_MPLANE);
    return Error{fmt::format("'{}' is a video device that captures no images", device), ENODEV};
}

std::vector<std::uint32_t> formats_of(SystemCalls &calls, int fd, std::uint32_t type) {
    std::vector<std::uint32_t> formats;
    v4l2_fmtdesc format = {};
    format.type = type;
    for (; calls.ioctl(fd, VIDIOC_ENUM_FMT, &format) == 0; ++format.index)
        formats.push_back(format.pixelformat);
    return formats;
}

double best_rate(SystemCalls &calls, int fd, std::uint32_t fourcc, const FormatRequest &request) {
    v4l2_frmivalenum interval = {};
    interval.pixel_format = fourcc;
    interval.width = static_cast<std::uint32_t>(request.width);
    interval.height = static_cast<std::uint32_t>(request.height);
    double best = 0;
    for (; calls.ioctl(fd, VIDIOC_ENUM_FRAMEINTERVALS, &interval) == 0; ++interval.index) {
        if (interval.type != V4L2_FRMIVAL_TYPE_DISCRETE)
            return std::min(request.fps, rate_of(interval.stepwise.min));
        best = std::max(best, rate_of(interval.discrete));
    }
    return interval.index == 0 ? request.fps : std::min(request.fps, best);
}

Result<FrameLayout> negotiate(SystemCalls &calls, int fd, const FormatRequest &request) {
    const Result<std::uint32_t> type = capture_type(calls, fd, request.device);
    if (!type)
        return type.error();
    const std::vector<std::uint32_t> offered = formats_of(calls, fd, *type);
    const std::uint32_t fourcc = choose(calls, fd, offered, request);
    if (fourcc == 0)
        return no_format(offered, request);
    Result<FrameLayout> layout = set_format(calls, fd, *type, fourcc, request);
    if (layout)
        layout->period_ns = set_rate(calls, fd, *type, request.fps);
    return layout;
}

void forbid_slow_exposure(SystemCalls &calls, int fd) {
    // exposure_dynamic_framerate; exposure_auto_priority before Linux 5.9. Most have neither.
    v4l2_control control = {V4L2_CID_EXPOSURE_AUTO_PRIORITY, 0};
    calls.ioctl(fd, VIDIOC_S_CTRL, &control);
}

} // namespace afterglow::v4l2
