// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "core/base/camera.hpp"

#include <cstdint>

namespace afterglow {

/// The camera of all ICL-NUIM sequences. Published with fy = -480, because the renderer's y axis
/// points up; ours points down, as the rows of the images do.
inline constexpr Intrinsics icl_nuim_camera = {481.2, 480, 319.5, 239.5, 640, 480};

/// Frames are numbered, 30 of them a second.
inline constexpr std::int64_t icl_nuim_time_ns(std::int64_t frame) {
    return frame * 1'000'000'000 / 30;
}

} // namespace afterglow
