// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "core/base/image.hpp"

#include <cstdint>
#include <vector>

namespace afterglow {

/// The error model of a TOF camera. Metres; z is the true depth.
struct TofNoise {
    double sigma_at_0 = 0.002;       ///< standard deviation of depth: sigma_at_0 +
    double sigma_per_square = 0.001; ///< sigma_per_square * z^2
    double nearest = 0.25;           ///< there is no depth nearer than this
    double furthest = 5.0;           ///< or further
    /// Pixels brighter than this are saturated and have no depth. Brightness is that of the
    /// returned light, luma / 255 / z^2 with z in metres; 0 = never.
    double saturation = 0;
    /// Chance that a pixel beside a depth edge sees both sides of it and measures something
    /// between them.
    double flying = 0.5;
    double edge = 0.05;    ///< an edge is a step of more than this share of z
    double range_bias = 0; ///< added to every depth, metres
    int lag_frames = 0;    ///< a depth map shows what was there so many images earlier

    /// No errors but rounding to millimetres.
    static TofNoise none() { return {0, 0, 0, 65.535, 0, 0, 0}; }
};

/// The noise of both cameras, reproducible: it depends on the seed and the frame's index, and on
/// nothing that was asked before.
class Noise {
public:
    Noise(std::uint64_t seed, const TofNoise &tof);

    /// What the TOF camera measures, in whole millimetres, where the true depth is `z` (metres;
    /// 0 = nothing there) and the image `luma`. All three have one size. Allocates nothing.
    void measure(std::uint64_t frame, ImageView<const float> z, LumaView luma,
                 ImageView<std::uint16_t> depth) const;

    /// Adds the image sensor's noise, of a standard deviation of 1.5. Allocates nothing.
    void add_to(std::uint64_t frame, ImageView<std::uint8_t> luma) const;

    /// Adds noise whose variance is the amplitude itself, as that of counted light. Allocates
    /// nothing.
    void add_shot_noise_to(std::uint64_t frame, ImageView<std::uint16_t> amplitude) const;

private:
    std::uint64_t seed_;
    TofNoise tof_;
    std::vector<float> normal_; // draws from the standard normal distribution
};

} // namespace afterglow
