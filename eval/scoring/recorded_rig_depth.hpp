// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "core/base/image.hpp"
#include "core/base/result.hpp"
#include "core/base/worker_pool.hpp"
#include "core/rig/rig_pipeline.hpp"
#include "drivers/files/recording.hpp"

#include <cstddef>

namespace afterglow {

/// What stands for the true depth of a recording of two cameras: the map that was recorded with an
/// image, seen by the published camera as a measurement is that follows none. It does not know how
/// the cameras move, corrects no calibration, and shows what was there when the map was taken.
class RecordedRigDepth {
public:
    explicit RecordedRigDepth(const RigGeometry &geometry);

    /// Millimetres. An Error where one of the entry's files cannot be read.
    Result<DepthMap> at(const Recording &recording, std::size_t entry);

private:
    WorkerPool pool_;
    RigPipeline pipeline_;
    Luma luma_;
    DepthMap map_;
};

} // namespace afterglow
