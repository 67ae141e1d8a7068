// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "core/base/camera_model.hpp"
#include "core/base/image.hpp"
#include "core/rig/pixel_places.hpp"

#include <vector>

namespace afterglow {

/// Shows a camera's image as a pinhole camera at the same place would have taken it.
///
/// The places of all pixels are worked out once, in 1/64 pixel; an image that has more than 1.5
/// pixels to one of the result is first halved, 2x2 to one, as often as it takes. Pixels that the
/// camera does not see are 0. Allocates when made; run() is real-time safe.
class LumaResampler {
public:
    LumaResampler(const CameraModel &from, const Intrinsics &to);

    LumaView run(LumaView image);

private:
    std::vector<Luma> halved_;
    std::vector<Tap> taps_;
    Luma result_;
};

} // namespace afterglow
