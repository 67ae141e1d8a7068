// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "drivers/v4l2/system_calls.hpp"

#include <cstdint>
#include <string>
#include <vector>

namespace afterglow {

/// What a video node gives: a format that can be read, its largest size, and the rate there.
struct V4l2Mode {
    std::string format; ///< FourCC
    int width = 0;
    int height = 0;
    double fps = 0; ///< 0: the driver does not say
    bool is_depth = false;
};

/// A control that may switch a light, judged by its name.
struct V4l2LightControl {
    std::string name;
    std::int64_t minimum = 0;
    std::int64_t maximum = 0;
};

/// A node, or a subdevice, that captures or has a light.
struct V4l2Listing {
    std::string path;
    std::string card;
    std::string stable_name;     ///< in /dev/v4l/by-id or by-path; or else the bus information
    std::vector<V4l2Mode> modes; ///< one for each format and size
    std::vector<V4l2LightControl> lights;
};
std::vector<V4l2Listing> list_v4l2_devices(SystemCalls &calls = linux_calls());

} // namespace afterglow
