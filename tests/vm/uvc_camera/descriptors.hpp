// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstdint>
#include <string>
#include <vector>

namespace afterglow::vm {

/// A format of the camera: 8-bit luma, luma with colour between (YUY2), or 16-bit depth.
struct UvcFormat {
    std::array<char, 4> code;
    std::uint8_t bytes_per_pixel;
    bool is_depth = false;
};
struct UvcSize {
    std::uint16_t width;
    std::uint16_t height;
};

inline constexpr std::array uvc_formats = {UvcFormat{{'Y', '8', '0', '0'}, 1},
                                           UvcFormat{{'Y', 'U', 'Y', '2'}, 2},
                                           UvcFormat{{'Z', '1', '6', ' '}, 2, true}};
inline constexpr std::array uvc_sizes = {UvcSize{640, 480}, UvcSize{320, 240}, UvcSize{160, 120},
                                         UvcSize{1280, 720}};
/// Of every format and size; 100 ns.
inline constexpr std::array<std::uint32_t, 4> uvc_intervals = {166'666, 333'333, 666'666,
                                                               2'000'000};

/// The three alternate settings of the streaming interface: no bandwidth, 8 and 24 MB a second.
inline constexpr std::array<std::uint32_t, 3> packet_bytes = {0, 1024, 3072};

/// Units of the video function.
enum : std::uint8_t { camera_terminal = 1, processing_unit = 2 };

using Descriptor = std::vector<std::uint8_t>;
Descriptor device_descriptor();
Descriptor configuration_descriptor();
/// String 0 is the languages; 1 to 3 are maker, product and serial number.
Descriptor string_descriptor(int index, const std::string &serial);

} // namespace afterglow::vm
