// SPDX-License-Identifier: Apache-2.0
#include "core/estimator.hpp"

#include "core/keyframe/keyframe_pipeline.hpp"
#include "core/paper/paper_pipeline.hpp"

#include <variant>

namespace afterglow {

std::optional<EstimatorOptions> estimator_preset(std::string_view name) {
    EstimatorOptions options;
    if (name == "default")
        return options;
    if (name == "paper") {
        options.method = Method::paper;
        return options;
    }
    return std::nullopt;
}

struct Estimator::State {
    State(const EstimatorOptions &options, const Intrinsics &camera, WorkerPool &pool) {
        if (options.method == Method::paper)
            pipeline.emplace<PaperPipeline>(options, camera, pool);
        else
            pipeline.emplace<KeyframePipeline>(options.keyframe, camera, pool);
    }

    std::variant<std::monostate, PaperPipeline, KeyframePipeline> pipeline;
};

Estimator::Estimator(const EstimatorOptions &options, const Intrinsics &camera, WorkerPool &pool)
    : state_(std::make_unique<State>(options, camera, pool)) {}
Estimator::~Estimator() = default;
Estimator::Estimator(Estimator &&) noexcept = default;

const Estimate &Estimator::track(LumaView luma, std::int64_t t_ns) {
    if (auto *paper = std::get_if<PaperPipeline>(&state_->pipeline))
        return paper->track(luma, t_ns);
    return std::get_if<KeyframePipeline>(&state_->pipeline)->track(luma, t_ns);
}

const Estimate &Estimator::measure(DepthView depth) {
    if (auto *paper = std::get_if<PaperPipeline>(&state_->pipeline))
        return paper->measure(depth);
    return std::get_if<KeyframePipeline>(&state_->pipeline)->measure(depth);
}

} // namespace afterglow
