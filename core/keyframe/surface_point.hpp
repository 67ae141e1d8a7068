// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <bit>
#include <cstdint>

namespace afterglow {

/// The depth of a surface's point, metres, 0 = none, keeps the point's edge distance, pixels, in
/// its lowest bits: who looks up a point knows both. It changes the depth by less than 10^-6 of it.
constexpr std::uint32_t edge_distance_bits = 7;

constexpr std::uint8_t edge_distance_of(float z) {
    return static_cast<std::uint8_t>(std::bit_cast<std::uint32_t>(z) & edge_distance_bits);
}
constexpr float with_edge_distance(float z, std::uint8_t edge_distance) {
    const auto bits = std::bit_cast<std::uint32_t>(z);
    return std::bit_cast<float>(bits == 0 ? 0 : (bits & ~edge_distance_bits) | edge_distance);
}

} // namespace afterglow
