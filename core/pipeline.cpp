// SPDX-License-Identifier: Apache-2.0
#include "core/pipeline.hpp"

#include "core/keyframe/keyframe_pipeline.hpp"
#include "core/paper/paper_pipeline.hpp"

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

PipelineFactory pipeline_factory(const EstimatorOptions &options, WorkerPool &pool) {
    return [options, &pool](const Intrinsics &camera) -> std::unique_ptr<Pipeline> {
        if (options.method == Method::paper)
            return std::make_unique<PaperPipeline>(options, camera, pool);
        return std::make_unique<KeyframePipeline>(options.keyframe, camera, pool);
    };
}

} // namespace afterglow
