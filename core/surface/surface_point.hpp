// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <bit>
#include <cstdint>

namespace afterglow {

/// Edge distances are counted up to this many pixels.
constexpr int far_from_edge = 7;
/// Points on a depth edge have an edge distance of 1.
constexpr int beside_edge = 2;

/// The depth of a surface's point, metres, 0 = none, keeps the point's edge distance, pixels, in
/// its lowest bits: who looks up a point knows both. It changes the depth by less than 10^-6 of it.
constexpr std::uint32_t edge_distance_bits = 7;
static_assert(far_from_edge <= edge_distance_bits);

constexpr std::uint8_t edge_distance_of(float z) {
    return static_cast<std::uint8_t>(std::bit_cast<std::uint32_t>(z) & edge_distance_bits);
}
constexpr float with_edge_distance(float z, std::uint8_t edge_distance) {
    const auto bits = std::bit_cast<std::uint32_t>(z);
    return std::bit_cast<float>(bits == 0 ? 0 : (bits & ~edge_distance_bits) | edge_distance);
}

} // namespace afterglow
