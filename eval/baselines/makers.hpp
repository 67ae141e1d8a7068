// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "eval/baselines/systems.hpp"

namespace afterglow {

/// One for each system; each is defined in the file that has the system's name.
using SystemMaker = std::unique_ptr<Pipeline>(const SystemInputs &inputs, const Intrinsics &camera);
SystemMaker make_non_adaptive;
SystemMaker make_reverse_warp;
SystemMaker make_lucas_kanade;
SystemMaker make_median_filtered;
SystemMaker make_flow_copy;
SystemMaker make_sfm_sift;
SystemMaker make_sfm_surf;
SystemMaker make_sfm_orb;
SystemMaker make_rgbd_odometry;

} // namespace afterglow
