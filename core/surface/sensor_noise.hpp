// SPDX-License-Identifier: Apache-2.0
#pragma once

namespace afterglow {

/// Standard deviation of one depth reading: sigma(z) = floor + linear z + quadratic z^2, metres.
/// The defaults are a Kinect-class structured-light sensor's, axial (Nguyen, Izadi and Lovell,
/// 3DIMPVT 2012: 1.2 mm + 1.9 mm (z - 0.4)^2, multiplied out). A continuous-wave TOF camera is
/// nearer to floor 2 mm, linear 0.002, quadratic 0.
struct SensorNoise {
    float floor_m = 0.0015f;
    float linear = -0.0015f;
    float quadratic_per_m = 0.0019f;
    /// Nothing is better than this share of the depth (quantisation, calibration).
    float least_relative = 0.001f;

    /// Metres at depth z metres.
    float sigma(float z) const {
        const float s = floor_m + z * (linear + z * quadratic_per_m);
        const float least = least_relative * z;
        return s > least ? s : least;
    }
    /// That of a sensor `factor` times as noisy.
    SensorNoise times(float factor) const {
        return {factor * floor_m, factor * linear, factor * quadratic_per_m,
                factor * least_relative};
    }
};

} // namespace afterglow
