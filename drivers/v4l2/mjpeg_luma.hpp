// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "drivers/v4l2/luma_reader.hpp"

namespace afterglow::v4l2 {

/// Reads the luma of Motion-JPEG frames; their colour is not even decoded. Frames that end early
/// or are damaged within are refused; the stray bytes that many cameras leave are not minded.
LumaReader make_mjpeg_reader();

} // namespace afterglow::v4l2
