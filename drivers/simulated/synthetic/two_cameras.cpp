// SPDX-License-Identifier: Apache-2.0
#include "drivers/simulated/synthetic/two_cameras.hpp"

#include <cmath>
#include <utility>

namespace afterglow {

TwoCameras::TwoCameras(const SyntheticOptions &options, SyntheticWorld world)
    : rig_(synthetic_rig(options)), fps_(options.fps),
      lag_s_(rig_.tof_delay_s - (options.noise ? world.tof.lag_frames / options.fps : 0)),
      noisy_(options.noise), world_(std::move(world)), noise_(options.seed, TofNoise::none()),
      exposure_(options.seed, options.exposure_changes), color_(world_.scene, rig_.color),
      tof_(world_.scene, options, world_.tof) {}

std::optional<std::int64_t> TwoCameras::time_ns(std::uint64_t k) const {
    return std::llround(time_s(k) * 1e9);
}

Status TwoCameras::read_luma(std::uint64_t k, ImageView<std::uint8_t> luma) {
    color_.render({.body = world_.camera, .t_s = time_s(k), .readout_s = rig_.readout_s}, luma);
    exposure_.apply(time_s(k), luma);
    if (noisy_)
        noise_.add_to(k, luma);
    return ok();
}

Status TwoCameras::read_depth(std::uint64_t k, ImageView<std::uint16_t> depth) {
    tof_.measure(
        k,
        {.body = world_.camera, .camera_from_body = rig_.tof_from_color, .t_s = time_s(k) + lag_s_},
        depth);
    return ok();
}

void TwoCameras::read_amplitude(std::uint64_t k, Image<std::uint16_t> &amplitude) {
    const Intrinsics &tof = rig_.tof.pinhole;
    if (amplitude.width() != tof.width || amplitude.height() != tof.height)
        amplitude = Image<std::uint16_t>(tof.width, tof.height);
    tof_.read_amplitude(k, amplitude);
}

} // namespace afterglow
