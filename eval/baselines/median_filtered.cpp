// SPDX-License-Identifier: Apache-2.0
#include "core/paper/paper_pipeline.hpp"
#include "eval/baselines/makers.hpp"
#include "tools/picture/opencv_image.hpp"

#include <opencv2/imgproc.hpp>

namespace afterglow {
namespace {

/// The paper's pipeline with the filter that it considers for its holes (Section IV-C): each pixel
/// becomes the median of the 3x3 around it, holes counting as 0.
class MedianFiltered final : public PaperPipeline {
public:
    using PaperPipeline::PaperPipeline;

private:
    void reproject(DepthView measured, const Pose &pose, ImageView<std::uint16_t> depth) override {
        PaperPipeline::reproject(measured, pose, depth);
        const cv::Mat map = as_mat(depth);
        cv::medianBlur(map, map, 3);
    }
};

} // namespace

std::unique_ptr<Pipeline> make_median_filtered(const SystemInputs &inputs,
                                               const Intrinsics &camera) {
    return std::make_unique<MedianFiltered>(inputs.options, camera, inputs.pool);
}

} // namespace afterglow
