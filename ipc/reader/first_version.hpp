// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "afterglow/afterglow.h"

#include <cstddef>

/// The sizes of the structs in the first version that had them: no daemon and no caller has less.
/// They never change, however much the structs grow.
namespace afterglow::first_version {

// afterglow/ring.h, version 2.0.
constexpr std::size_t header_size = 192;
constexpr std::size_t plane_size = 40;
constexpr std::size_t frame_size = 328;
constexpr std::size_t message_size = 16;

// afterglow/afterglow.h of the library's version 1.0.
constexpr std::size_t options_size = offsetof(afterglow_options, interval_ms) + 4;
constexpr std::size_t info_size = offsetof(afterglow_info, ring_minor) + 4;
constexpr std::size_t plane_info_size = offsetof(afterglow_plane_info, unit) + 8;

static_assert(sizeof(afterglow_ring_header) >= header_size &&
              offsetof(afterglow_ring_header, live_reserved_2) + 40 == header_size);
static_assert(sizeof(afterglow_plane) >= plane_size &&
              offsetof(afterglow_plane, unit) + 8 == plane_size);
static_assert(sizeof(afterglow_frame) >= frame_size &&
              offsetof(afterglow_frame, camera_from_measurement) + 96 == frame_size);
static_assert(sizeof(afterglow_message) >= message_size &&
              offsetof(afterglow_message, value) + 8 == message_size);

} // namespace afterglow::first_version
