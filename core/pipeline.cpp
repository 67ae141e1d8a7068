// SPDX-License-Identifier: Apache-2.0
#include "core/pipeline.hpp"

#include "core/keyframe/keyframe_pipeline.hpp"
#include "core/paper/paper_pipeline.hpp"
#include "core/rig/rig_pipeline.hpp"

#include <cassert>

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
    return [options, &pool](const RigGeometry &geometry) -> std::unique_ptr<Pipeline> {
        assert(geometry.registered || options.method == Method::keyframe);
        if (!geometry.registered)
            return std::make_unique<RigPipeline>(options.keyframe, geometry, pool);
        if (options.method == Method::paper)
            return std::make_unique<PaperPipeline>(options, geometry.camera(), pool);
        return std::make_unique<KeyframePipeline>(options.keyframe, geometry.camera(), pool);
    };
}

} // namespace afterglow
