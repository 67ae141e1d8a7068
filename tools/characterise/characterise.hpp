// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "core/base/result.hpp"
#include "drivers/source.hpp"
#include "tools/characterise/edges.hpp"
#include "tools/characterise/noise_fit.hpp"

#include <atomic>
#include <optional>
#include <vector>

namespace afterglow {

struct CharacteriseOptions {
    double seconds = 30; ///< of images, dark ones not counted
    /// Times that the light goes on. 0: it cannot be switched, or there is none.
    int cycles = 5;
    SensorNoise noise{}; ///< as configured: the curve's shape where the view does not show one
};

/// What a TOF camera does after its light goes on.
struct WarmUp {
    int cycles = 0;
    int unsettled_maps = 0; ///< most maps of a cycle before those that agree
    double settled_ms = 0;  ///< longest time from light on to the first map that agrees
};

/// What half a minute of a still view tells of a TOF camera.
struct Characteristics {
    int width = 0, height = 0;
    int maps = 0; ///< settled ones
    std::vector<DepthBin> bins;
    NoiseFit fit;
    float shared_noise = 0;
    EdgeBehaviour edges;
    std::optional<WarmUp> warm_up; ///< nothing: the light was not switched
};

/// Measures the noise of the rig's TOF camera. Starts and stops both cameras, and leaves the light
/// dark. Errors: the view was not still, too few maps came, a camera or the light failed, or `stop`
/// was set.
Result<Characteristics> characterise(Rig &rig, const CharacteriseOptions &options,
                                     const std::atomic<bool> &stop);

} // namespace afterglow
