// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "drivers/openni2/openni2.hpp"

#include <OpenNI.h>
#include <optional>

namespace afterglow::openni2 {

/// Whether pixels are depth along Z, of one or a tenth of a millimetre.
bool is_depth(const openni::VideoMode &mode);
/// Units of a mode's pixels in a millimetre.
int units_per_mm(const openni::VideoMode &mode);
/// "640x480 at 30, 1 mm".
std::string describe(const openni::VideoMode &mode);

/// Of the modes with the maps' size the slowest that is fast enough, or else the fastest.
std::optional<openni::VideoMode> choose_mode(const openni::Array<openni::VideoMode> &modes,
                                             const OpenNi2Options &options);

} // namespace afterglow::openni2
