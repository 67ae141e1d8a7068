// SPDX-License-Identifier: Apache-2.0
#pragma once

namespace afterglow {

/// Whether a camera that offers `offered` frames per second will do where `wanted` are asked for:
/// 29.97 for 30.
constexpr bool is_as_fast(double offered, double wanted) {
    constexpr double tolerance = 0.98;
    return offered >= wanted * tolerance;
}

} // namespace afterglow
