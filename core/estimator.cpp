// SPDX-License-Identifier: Apache-2.0
#include "core/estimator.hpp"

#include "core/paper_pipeline.hpp"

namespace afterglow {

std::optional<EstimatorOptions> estimator_preset(std::string_view name) {
    if (name == "paper")
        return EstimatorOptions{};
    return std::nullopt;
}

struct Estimator::State {
    PaperPipeline pipeline;
};

Estimator::Estimator(const EstimatorOptions &options, const Intrinsics &camera, WorkerPool &pool)
    : state_(new State{{options, camera, pool}}) {}
Estimator::~Estimator() = default;
Estimator::Estimator(Estimator &&) noexcept = default;

const Estimate &Estimator::track(LumaView luma, std::int64_t t_ns) {
    return state_->pipeline.track(luma, t_ns);
}

const Estimate &Estimator::measure(DepthView depth) {
    return state_->pipeline.measure(depth);
}

} // namespace afterglow
