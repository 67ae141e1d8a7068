// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "afterglow/afterglow.h"

#include <cstdint>
#include <string>

/// afterglow_open() on the bus at an address.
inline int open_stream(const std::string &bus, afterglow_stream **stream, std::uint32_t flags = 0) {
    afterglow_options options = {};
    options.size = sizeof options;
    options.flags = flags;
    options.bus = bus.c_str();
    return afterglow_open(&options, stream);
}

/// A frame to read into.
inline afterglow_frame empty_frame() {
    afterglow_frame frame = {};
    frame.size = sizeof frame;
    return frame;
}
