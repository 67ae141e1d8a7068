// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "tools/bench/frame/tour.hpp"

namespace afterglow::bench {

// Register benchmarks with Google Benchmark. An iteration is a frame; a benchmark always goes
// through the whole tour. `tour` must outlive the run.

void register_pipelines(const Tour &tour); ///< frame/..., measure/default
void register_kernels(const Tour &tour);   ///< warp, align, limit/memcpy
void register_opencv(const Tour &tour);    ///< opencv/...

} // namespace afterglow::bench
