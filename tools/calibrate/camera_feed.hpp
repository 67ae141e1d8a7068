// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "config/config.hpp"
#include "core/base/result.hpp"
#include "drivers/source.hpp"

#include <string>

namespace afterglow {

/// Both cameras of a configuration, lit, one image after the other. One thread.
class CameraFeed {
public:
    /// Opens and starts them as the daemon does, and switches the light on. Errors: which of them
    /// cannot be opened, started or lit, and why.
    static Result<CameraFeed> open(const Config &config);
    CameraFeed(CameraFeed &&) = default;
    CameraFeed &operator=(CameraFeed &&) = delete;
    ~CameraFeed();

    /// Waits for the next image, and takes the depth maps that have come meanwhile: false when a
    /// recording is over. Errors: a camera is gone, or no image came for a long time.
    Result<bool> next();

    const ColorFrame &color() const { return color_; }
    /// Whether there has been a depth map, which is the newest then.
    bool has_tof() const { return has_tof_; }
    const DepthFrame &tof() const { return tof_; }

private:
    explicit CameraFeed(Rig rig);
    Status take_maps();

    Rig rig_;
    ColorFrame color_;
    DepthFrame tof_;
    bool has_tof_ = false;
};

} // namespace afterglow
