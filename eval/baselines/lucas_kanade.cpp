// SPDX-License-Identifier: Apache-2.0
#include "core/paper/paper_pipeline.hpp"
#include "eval/baselines/makers.hpp"
#include "eval/baselines/table_1.hpp"

namespace afterglow {
namespace {

/// The paper's pipeline, its flow by Lucas-Kanade (Noraky & Sze 2019, Section VI-A).
class LucasKanade final : public PaperPipeline {
public:
    using PaperPipeline::PaperPipeline;

private:
    void find_flow(LumaView previous, LumaView next, std::vector<Match> &matches) override {
        find_lucas_kanade_flow(options().flow, previous, next, matches);
    }
};

} // namespace

std::unique_ptr<Pipeline> make_lucas_kanade(const SystemInputs &inputs, const Intrinsics &camera) {
    return std::make_unique<LucasKanade>(inputs.options, camera, inputs.pool);
}

} // namespace afterglow
