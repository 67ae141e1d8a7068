// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "core/base/camera.hpp"
#include "core/base/result.hpp"
#include "drivers/source.hpp"
#include "drivers/v4l2/depth_layout.hpp"
#include "drivers/v4l2/system_calls.hpp"

#include <cstdint>
#include <memory>
#include <string>

namespace afterglow {

// Cameras and lights of the Linux kernel's V4L2 API.
//
// A `device` is named by its path ("/dev/video0"), by its name in /dev/v4l/by-id or
// /dev/v4l/by-path ("usb-046d_HD_Webcam-video-index0"), or by the bus information or card name that
// `v4l2-ctl --info` prints ("usb-0000:00:14.0-3"): all but the first survive a replug into another
// node. open_...() refuses options that no device could satisfy and leaves the device alone: it
// may be plugged in later. start() opens it, and after Capture::lost opens it anew.

struct V4l2ColorOptions {
    std::string device;
    Intrinsics camera; ///< width and height are asked of the device, which must have them
    double fps = 30;   ///< asked of the device, which gives the nearest rate it has
    /// A FourCC as `v4l2-ctl --list-formats` prints it; "" takes the one of those with this size
    /// and rate whose luma costs least to read.
    std::string format;
};

/// An ordinary camera. ColorFrame::t_ns is when the exposure began, as near as the driver says:
/// stamps of the frame's end are set back by one frame, and stamps that are not on
/// CLOCK_MONOTONIC are replaced by the time of arrival. Whoever is late gets the newest image;
/// those passed over are gaps in the sequence.
Result<std::unique_ptr<ColorSource>> open_v4l2_color(const V4l2ColorOptions &options,
                                                     SystemCalls &calls = linux_calls());

struct V4l2TofOptions {
    std::string device;
    Intrinsics camera; ///< of the TOF camera; maps have its size, the node's frames what holds them
    double fps = 30;
    std::string format; ///< a FourCC; "" = the first the device has that may be depth
    double mm_per_unit = 1;
    int invalid = 0; ///< the number that means "no depth"; besides, 0 always does
    DepthPacking packing{};
    std::string amplitude_device{}; ///< of another node that gives the maps' amplitude; "" = none
    std::string amplitude_format{}; ///< its FourCC; "" = the first of its that may be amplitude
};

/// A camera node whose pixels are depth, with or without amplitude. Maps come in order; none is
/// passed over. A light that is off may make it fall silent, so silence is not taken for a loss.
/// Amplitude of another node is that of the map's time; while that node is lost or gives none,
/// maps come without, and take_warning() says so. Refuses packings that no frame can have; start()
/// fails if the device's frames, or the other node's, are others than these.
Result<std::unique_ptr<TofSource>> open_v4l2_tof(const V4l2TofOptions &options,
                                                 SystemCalls &calls = linux_calls());

struct V4l2ControlOptions {
    std::string device;  ///< a video node as above, or the path of a subdevice ("/dev/v4l-subdev0")
    std::string control; ///< "flash_led_mode" as `v4l2-ctl --list-ctrls` prints it, or "0x009c0901"
    std::int64_t on = 1;
    std::int64_t off = 0;
    std::string off_control; ///< where another control is what darkens ("strobe_stop"); "" = same
};

/// A light that a V4L2 control switches: a flash LED's mode or strobe, a private control of a TOF
/// sensor. Errors: the device has no such control, or not those values. A device that is not
/// there yet is none: set() finds it when it comes.
Result<std::unique_ptr<Illuminator>> open_v4l2_control(const V4l2ControlOptions &options,
                                                       SystemCalls &calls = linux_calls());

} // namespace afterglow
