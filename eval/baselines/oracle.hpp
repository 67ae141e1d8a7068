// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "core/pipeline.hpp"
#include "eval/scoring/footage.hpp"

namespace afterglow {

/// A pipeline that no real system can be: the pose of each image is refined on the true depth of
/// that image, and the error and coverage that it expects are the true ones. What error is left is
/// not the pose's: noise of the sensor, occlusion, depth that was never measured.
///
/// It starts from the pose that the pipeline of the same options tracks, and gives that one's map
/// where it is the better of the two, or where the true depth cannot be read.
PipelineFactory oracle_factory(const EstimatorOptions &options, WorkerPool &pool, TruthAt truth);

} // namespace afterglow
