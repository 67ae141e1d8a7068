// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "core/base/image.hpp"
#include "drivers/simulated/synthetic/lens_renderer.hpp"

#include <complex>
#include <vector>

namespace afterglow {

/// At this distance the phase of a TOF camera's light has turned once; metres. Nothing in a room is
/// as far.
inline constexpr float unambiguous_range = 15;

/// Light that reaches a point not from the lamp but from another point of the scene, as it does in
/// concave corners: its way is longer, and so is the depth that is measured.
///
/// All surfaces are matt (Lambert's law). Of a point X the lamp lights directly, another one at Y
/// of albedo rho sends to X, as a share of that light,
///     rho w (n_Y . YX)+ (n_X . XY)+ |X|^2 / (pi |Y - X|^2 cos a),
/// where w is the solid angle at which lamp and camera, both at the origin, see the patch at Y,
/// YX and XY are directions, and a is the angle between the light and the normal at X. It comes
/// back with the distance (|Y| + |Y - X| + |X|) / 2. (The first bounce of radiosity: Goral et al.,
/// SIGGRAPH 1984; for TOF cameras Fuchs, ICPR 2010.) Y is looked for at 40 places around a pixel,
/// in rings, and only where the camera sees; luma stands for the albedo.
class SecondBounce {
public:
    /// `strength`: factor on all of this light; 1 is as above.
    SecondBounce(const PixelRays &rays, double strength);

    /// For each pixel of what `renderer` drew last, with normals and `luma`, the factor between
    /// its light and that of the direct way alone, as complex amplitudes. Allocates nothing.
    ImageView<const std::complex<float>> factors(const LensRenderer &renderer, LumaView luma);

private:
    struct Place {
        int u, v;     ///< from the pixel
        float pixels; ///< for how many it stands
    };
    std::complex<float> factor_at(int u, int v, ImageView<const Eigen::Vector3f> normals,
                                  LumaView luma) const;

    float strength_;
    std::vector<Place> places_;
    Image<float> solid_angle_;
    Image<Eigen::Vector3f> points_; ///< 0: nothing is seen
    Image<std::complex<float>> factors_;
};

} // namespace afterglow
