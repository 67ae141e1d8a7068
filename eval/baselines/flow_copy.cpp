// SPDX-License-Identifier: Apache-2.0
#include "core/paper/published_frame.hpp"
#include "eval/baselines/makers.hpp"
#include "tools/picture/opencv_image.hpp"

#include <algorithm>
#include <cmath>
#include <opencv2/video/tracking.hpp>

namespace afterglow {
namespace {

/// The causal variant of Wang 2010 that Noraky & Sze 2019 calls Copy (Section VI-C1): every pixel
/// takes the previous map's depth from where dense flow (Farneback 2003) says it came from.
class FlowCopy final : public Pipeline {
public:
    explicit FlowCopy(const Intrinsics &camera)
        : frame_(camera), previous_depth_(camera.width, camera.height) {}

    const Estimate &track(LumaView luma, std::int64_t t_ns) override {
        frame_.begin(t_ns);
        const bool following = frame_.has_depth();
        if (following)
            copy_depth(as_mat(luma));
        as_mat(luma).copyTo(previous_luma_);
        return following ? frame_.give_estimated() : frame_.give_nothing();
    }

    const Estimate &measure(const Measurement &measured) override {
        return frame_.give_measured(measured.depth);
    }
    void restart() override { frame_.give_nothing(); }

private:
    void copy_depth(const cv::Mat &luma) {
        // The constants of OpenCV's own example (samples/cpp/fback.cpp).
        constexpr double scale = 0.5;
        constexpr int levels = 3, window = 15, iterations = 3, neighbourhood = 5;
        constexpr double sigma = 1.2;
        cv::Mat_<cv::Vec2f> flow; // from this image to the previous
        cv::calcOpticalFlowFarneback(luma, previous_luma_, flow, scale, levels, window, iterations,
                                     neighbourhood, sigma, 0);
        std::ranges::copy(frame_.depth().pixels(), previous_depth_.pixels().begin());
        for (int v = 0; v < flow.rows; ++v) {
            for (int u = 0; u < flow.cols; ++u) {
                const float from_u = std::round(static_cast<float>(u) + flow(v, u)[0]);
                const float from_v = std::round(static_cast<float>(v) + flow(v, u)[1]);
                const bool inside = from_u >= 0 && from_v >= 0 &&
                                    from_u < static_cast<float>(flow.cols) &&
                                    from_v < static_cast<float>(flow.rows);
                frame_.depth()(u, v) =
                    inside ? previous_depth_(static_cast<int>(from_u), static_cast<int>(from_v))
                           : std::uint16_t{0};
            }
        }
    }

    PublishedFrame frame_;
    DepthMap previous_depth_;
    cv::Mat previous_luma_;
};

} // namespace

std::unique_ptr<Pipeline> make_flow_copy(const SystemInputs &, const Intrinsics &camera) {
    return std::make_unique<FlowCopy>(camera);
}

} // namespace afterglow
