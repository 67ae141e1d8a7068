// SPDX-License-Identifier: Apache-2.0
#include "core/paper/paper_pipeline.hpp"
#include "core/paper/pose_solver.hpp"
#include "eval/baselines/makers.hpp"

namespace afterglow {
namespace {

/// Noraky & Sze 2017: the linear least squares of all flow, right or wrong. It never asks for a
/// measurement while it has a solution.
class NonAdaptive final : public PaperPipeline {
public:
    using PaperPipeline::PaperPipeline;

private:
    std::optional<RansacPose::Solution> find_motion(std::span<const Match> matches) override {
        const auto pose = solve_pose(matches, camera(), 1);
        if (!pose)
            return std::nullopt;
        return RansacPose::Solution{*pose, static_cast<int>(matches.size())};
    }
};

} // namespace

std::unique_ptr<Pipeline> make_non_adaptive(const SystemInputs &inputs, const Intrinsics &camera) {
    return std::make_unique<NonAdaptive>(inputs.options, camera, inputs.pool);
}

} // namespace afterglow
