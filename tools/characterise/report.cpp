// SPDX-License-Identifier: Apache-2.0
#include "tools/characterise/report.hpp"

#include <fmt/format.h>

#include <algorithm>

namespace afterglow {
namespace {

float curve(const SensorNoise &noise, float z) {
    return noise.floor_m + z * (noise.linear + z * noise.quadratic_per_m);
}

std::string noise_table(const Characteristics &found) {
    std::string out = "# Noise of a reading (one sigma), away from depth edges:\n"
                      "#   depth m   measured mm   fitted mm   places\n";
    for (const DepthBin &bin : found.bins)
        out += fmt::format("#   {:7.2f}   {:11.2f}   {:9.2f}   {:6}\n", bin.z_m, 1000 * bin.sigma_m,
                           1000 * curve(found.fit.noise, bin.z_m), bin.pixels);
    return out;
}

/// What the view did not show.
std::string coverage(const Characteristics &found, const SurfaceOptions &configured) {
    const float nearest = found.bins.front().z_m, farthest = found.bins.back().z_m;
    std::string out =
        fmt::format("# Surfaces from {:.2f} to {:.2f} m were in view.\n", nearest, farthest);
    if (found.fit.scaled)
        out += "# That is too little for a curve: it is the configured one, multiplied. Take a "
               "view with\n# surfaces near and far.\n";
    if (nearest > 1.5F * configured.nearest_m || farthest < 0.67F * configured.farthest_m)
        out += fmt::format("# What the curve says of the rest of {:g} to {:g} m is a guess.\n",
                           configured.nearest_m, configured.farthest_m);
    if (found.fit.misfit > 0.25F)
        out += fmt::format("# The curve misses the worst of these by {:.0f} %: this sensor's noise "
                           "does not depend on\n# depth alone.\n",
                           100 * found.fit.misfit);
    return out;
}

std::string edges(const Characteristics &found, float configured_px) {
    constexpr int least_crossings = 50;
    const EdgeBehaviour &edge = found.edges;
    if (edge.crossings < least_crossings)
        return "# Too few depth edges were in view to tell how it behaves there.\n";
    std::string out =
        fmt::format("# At a depth edge ({} looked at) {:.2f} readings lie between both surfaces, "
                    "and it is\n# misplaced by {:.2f} pixels. The registration with the colour "
                    "camera comes on top.\n",
                    edge.crossings, edge.flying, edge.misplaced_px);
    if (edge.misplaced_px > configured_px)
        out += fmt::format("edge_registration_px = {:.2f}\n", edge.misplaced_px);
    return out;
}

std::string warm_up(const std::optional<WarmUp> &found) {
    if (!found)
        return "\n# The light was not switched: nothing is known of how the camera warms up.\n";
    // A map is settled when it agrees with the one before it.
    return fmt::format("\n[tof]\n# In {} cycles at most {} maps after light on did not agree with "
                       "settled ones; the first that\n# did came {:.0f} ms after light on.\n"
                       "warmup_maps = {}\n",
                       found->cycles, found->unsettled_maps, found->settled_ms,
                       found->unsettled_maps + 2);
}

} // namespace

std::string report(const Characteristics &found, const Config &config) {
    const SurfaceOptions &surface = config.estimator.keyframe.surface;
    const SensorNoise &noise = found.fit.noise;
    return fmt::format("# Written by afterglowctl characterise from {} depth maps of {} x {}.\n",
                       found.maps, found.width, found.height) +
           noise_table(found) + coverage(found, surface) +
           fmt::format("[sensor]\nfloor_m = {:.6f}\nlinear = {:.6f}\nquadratic_per_m = {:.6f}\n",
                       noise.floor_m, noise.linear, noise.quadratic_per_m) +
           fmt::format("\n[error]\n# What is left of the noise in the mean of 5 x 5 readings: 0.2 "
                       "where neighbours have\n# nothing in common.\nshared_noise = {:.2f}\n",
                       found.shared_noise) +
           edges(found, config.estimator.keyframe.error.edge_registration_px) +
           warm_up(found.warm_up);
}

} // namespace afterglow
