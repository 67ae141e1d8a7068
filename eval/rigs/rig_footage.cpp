// SPDX-License-Identifier: Apache-2.0
#include "eval/rigs/rig_footage.hpp"

#include <Eigen/Geometry>

#include <algorithm>
#include <cmath>
#include <utility>

namespace afterglow {
namespace {

/// As many columns are enough to tell a share.
constexpr int columns_looked_at = 320;
/// Of z: what is further behind what the TOF camera sees is hidden from it.
constexpr double least_gap = 0.02;

Exposed exposure_of(const RigGeometry &geometry) {
    if (geometry.publishes_tof())
        return {.delay_s = geometry.rig.tof_delay_s};
    if (geometry.publishes_color())
        return {.readout_s = geometry.rig.readout_s};
    return {};
}

SyntheticOptions with_rig(SyntheticOptions options, const RigGeometry &geometry) {
    options.real_time = false;
    options.rig = geometry.rig;
    return options;
}

/// The length of the longest ray of a picture. Beyond it a lens may show a point twice.
double widest_ray(const CameraModel &camera) {
    const PixelRays rays(camera);
    double widest = 0;
    for (int v = 0; v < rays.height(); ++v)
        for (int u = 0; u < rays.width(); ++u)
            if (rays.is_seen(u, v))
                widest = std::max(widest, rays.at(u, v).norm());
    return widest;
}

} // namespace

RigTruth::RigTruth(const SyntheticOptions &options, const RigGeometry &geometry)
    : geometry_(geometry), exposed_(exposure_of(geometry)), published_(with_rig(options, geometry)),
      tof_(with_rig(options, geometry)), rays_(geometry.published),
      widest_(widest_ray(geometry.rig.tof)) {}

const DepthMap &RigTruth::depth(std::uint64_t sequence) {
    if (drawn_ != sequence)
        depth_ = published_.depth(sequence, geometry_.published, geometry_.published_from_color,
                                  exposed_);
    drawn_ = sequence;
    return depth_;
}

std::optional<double> RigTruth::coverage(std::uint64_t sequence, DepthView published) {
    const RigCalibration &rig = geometry_.rig;
    const DepthMap &truth = depth(sequence);
    const DepthMap seen =
        tof_.depth(sequence, rig.tof, rig.tof_from_color, {.delay_s = exposed_.delay_s});
    const Pose tof_from_published = rig.tof_from_color * geometry_.published_from_color.inverse();
    const int step = std::max(1, truth.width() / columns_looked_at);
    int can_be_seen = 0, covered = 0;
    for (int v = step / 2; v < truth.height(); v += step) {
        for (int u = step / 2; u < truth.width(); u += step) {
            if (truth(u, v) == 0)
                continue;
            const Eigen::Vector3d X =
                tof_from_published * (0.001 * truth(u, v) * rays_.at(u, v).homogeneous());
            if (!(X.z() > 0) || X.head<2>().norm() > widest_ * X.z())
                continue;
            const Eigen::Vector2d at = rig.tof.project(X);
            const int x = static_cast<int>(std::lround(at.x()));
            const int y = static_cast<int>(std::lround(at.y()));
            if (!seen.view().contains(x, y) || X.z() > 0.001 * seen(x, y) * (1 + least_gap))
                continue;
            ++can_be_seen;
            covered += published(u, v) > 0;
        }
    }
    return can_be_seen > 0 ? std::optional(100.0 * covered / can_be_seen) : std::nullopt;
}

Result<Footage> open_rig_footage(SyntheticOptions options, const RigGeometry &geometry,
                                 std::shared_ptr<RigTruth> truth) {
    options = with_rig(options, geometry);
    auto rig = open_synthetic(options);
    if (!rig)
        return rig.error();
    return Footage{
        .name = synthetic_name,
        .layout = synthetic_name,
        .rig = *std::move(rig),
        .geometry = geometry,
        .frames = options.frames,
        .problem = {},
        .assumed = {},
        .truth = [truth = std::move(truth)](std::uint64_t sequence) -> Result<DepthMap> {
            return truth->depth(sequence);
        },
        .sequence_at = synthetic_sequence_at(options.fps),
    };
}

} // namespace afterglow
