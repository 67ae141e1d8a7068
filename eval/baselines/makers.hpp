// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "eval/baselines/depth_system.hpp"

#include <memory>
#include <utility>

namespace afterglow {

/// Makes a DepthSystem of anything else that has track() and measure().
template <class Tracker>
class AsDepthSystem final : public DepthSystem {
public:
    template <class... Arguments>
    explicit AsDepthSystem(Arguments &&...arguments)
        : tracker_(std::forward<Arguments>(arguments)...) {}
    const Estimate &track(LumaView luma, std::int64_t t_ns) override {
        return tracker_.track(luma, t_ns);
    }
    const Estimate &measure(DepthView depth) override { return tracker_.measure(depth); }

private:
    Tracker tracker_;
};

/// One for each system; each is defined in the file that has the system's name.
using SystemMaker = std::unique_ptr<DepthSystem>(const EstimatorOptions &options,
                                                 const Intrinsics &camera, WorkerPool &pool);
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
