// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "core/base/image.hpp"
#include "drivers/simulated/synthetic/lens_renderer.hpp"
#include "drivers/simulated/synthetic/noise.hpp"
#include "drivers/simulated/synthetic/second_bounce.hpp"
#include "drivers/simulated/synthetic/synthetic.hpp"

#include <array>
#include <complex>
#include <cstdint>
#include <optional>

namespace afterglow {

/// A continuous-wave TOF camera in a synthetic scene.
///
/// It compares the light that comes back with the light sent, at four phases one after the other:
/// c_i = Re(a e^(j phi) e^(-j i pi / 2)), with phi = 2 pi range / unambiguous_range; the range is
/// the angle of (c_0 - c_2) + j (c_1 - c_3). (Lange and Seitz, IEEE J. Quantum Electronics 2001.)
/// What moves during its exposure is elsewhere in each, so that the edges of moving things smear.
class TofCamera {
public:
    /// That of synthetic_rig(). The scene must outlive it and not change.
    TofCamera(const Scene &scene, const SyntheticOptions &options, const TofNoise &noise);

    /// The depth map of a frame, whose exposure has its middle at the time of the shot, in
    /// millimetres as the device gives them: along Z, or along rays. Allocates nothing.
    void measure(std::uint64_t frame, const Shot &shot, ImageView<std::uint16_t> depth);

    /// The returned light of the map that was measured last, of that frame: 4095 for white at 1 m.
    /// Its noise is that of light, whose variance is its strength. Allocates nothing.
    void read_amplitude(std::uint64_t frame, ImageView<std::uint16_t> amplitude) const;

private:
    /// Adds the light that is seen at that time; `shares` of its real and imaginary parts.
    void expose(const Shot &shot, const std::array<float, 2> &shares);
    float ray_length(int u, int v) const;

    double exposure_s_;
    bool along_ray_;
    bool noisy_;
    Noise noise_;
    LensRenderer renderer_;
    std::optional<SecondBounce> second_bounce_;
    Luma luma_;
    Image<std::complex<float>> light_; ///< with the phase of its way
    Image<float> reading_;             ///< metres, before noise
};

} // namespace afterglow
