// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "core/base/camera.hpp"
#include "core/base/image.hpp"
#include "core/base/result.hpp"
#include "drivers/simulated/rounds.hpp"
#include "tools/testcam/settings.hpp"

#include <cstdint>
#include <memory>

namespace afterglow::testcam {

/// The depth that the camera sees: a recording, played in rounds in step with the driver "replay",
/// or a synthetic room.
class DepthSequence {
public:
    virtual ~DepthSequence() = default;
    virtual const Intrinsics &camera() const = 0;
    virtual double fps() const = 0;
    /// The first frame that is exposed after `after_ns`, CLOCK_MONOTONIC.
    virtual Rounds::Frame next(std::int64_t after_ns) const = 0;
    virtual Status read(std::uint64_t number, ImageView<std::uint16_t> depth_mm) = 0;
};

Result<std::unique_ptr<DepthSequence>> open_depth_sequence(const Settings &settings);

} // namespace afterglow::testcam
