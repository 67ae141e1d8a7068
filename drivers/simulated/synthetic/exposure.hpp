// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "core/base/image.hpp"

#include <cstdint>

namespace afterglow {

/// The automatic exposure of a camera: slow drift, and every two seconds a jump.
class Exposure {
public:
    static constexpr double most_stops = 4;

    /// `stops`: the factor is from 2^-stops to 2^stops; 0 = always 1.
    Exposure(std::uint64_t seed, double stops) : seed_(seed), stops_(stops) {}

    /// By what luma is multiplied in an image that is taken then.
    double factor(double t_s) const;
    /// Multiplies; what gets brighter than white is white. Allocates nothing.
    void apply(double t_s, ImageView<std::uint8_t> luma) const;

private:
    std::uint64_t seed_;
    double stops_;
};

} // namespace afterglow
