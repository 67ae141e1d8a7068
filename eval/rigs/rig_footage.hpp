// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "core/base/result.hpp"
#include "core/rig/rig_geometry.hpp"
#include "drivers/simulated/synthetic/pixel_rays.hpp"
#include "drivers/simulated/synthetic/truth.hpp"
#include "eval/scoring/footage.hpp"

#include <cstdint>
#include <memory>
#include <optional>

namespace afterglow {

/// The true depth in the published view of a rig, and how much of it the TOF camera can see.
class RigTruth {
public:
    RigTruth(const SyntheticOptions &options, const RigGeometry &geometry);

    /// Of the published camera, when its pixels are exposed: the colour camera's row by row, the
    /// TOF camera's when that measures, any other's at the image's time.
    const DepthMap &depth(std::uint64_t sequence);

    /// How much of what the TOF camera can see at that moment, in its picture and behind nothing,
    /// the published map covers: percent of pixels. Nothing where it can see nothing. Of large
    /// views some columns and rows are looked at.
    std::optional<double> coverage(std::uint64_t sequence, DepthView published);

private:
    RigGeometry geometry_;
    Exposed exposed_;
    SyntheticTruth published_, tof_; // each keeps the table of one lens
    DepthMap depth_;
    std::optional<std::uint64_t> drawn_; ///< of which image depth_ is
    PixelRays rays_;
    double widest_; ///< of the TOF camera's rays
};

/// The room as the cameras of a rig see it, which the pipeline is told as they are. Options out of
/// range are an Error.
Result<Footage> open_rig_footage(SyntheticOptions options, const RigGeometry &geometry,
                                 std::shared_ptr<RigTruth> truth);

} // namespace afterglow
