// SPDX-License-Identifier: Apache-2.0
#include "eval/baselines/oracle.hpp"

#include "core/calibration/depth_refinement.hpp"
#include "core/keyframe/depth_composer.hpp"
#include "core/keyframe/keyframe.hpp"
#include "eval/scoring/metrics.hpp"

#include <utility>

namespace afterglow {
namespace {

class Oracle final : public Pipeline {
public:
    Oracle(const EstimatorOptions &options, const Intrinsics &camera, WorkerPool &pool,
           TruthAt truth)
        : camera_(camera), options_(options.keyframe), pool_(pool),
          pipeline_(pipeline_factory(options, pool)(camera)), truth_at_(std::move(truth)),
          keyframes_(options_.compose.keyframes, camera, options_.surface,
                     options_.alignment_template),
          truth_(camera, options_.surface), composer_(camera, options_, pool) {}

    const Estimate &track(LumaView luma, std::int64_t t_ns) override {
        estimate_ = pipeline_->track(luma, t_ns);
        const auto truth = truth_at_(t_ns);
        if (keyframes_.size() == 0 || estimate_.source != FrameSource::estimated || !truth)
            return estimate_;
        truth_.build(*truth, pool_);
        const Pose tracked = estimate_.pose;
        now_ = (tracked * keyframes_[0].depth_from_world).normalized();
        DepthErrors errors = compare_depth(estimate_.depth, *truth);
        if (refine(tracked)) {
            const DepthErrors refined = compare_depth(composer_.depth(), *truth);
            if (refined.mre <= errors.mre) {
                errors = refined;
                estimate_.depth = composer_.depth();
                estimate_.confidence = composer_.confidence();
            }
        }
        estimate_.expected_mre = estimate_.independent_mre = static_cast<float>(errors.mre);
        estimate_.fresh_mre = estimate_.moved_mre = 0;
        estimate_.relative_coverage = static_cast<float>(errors.coverage());
        return estimate_;
    }

    const Estimate &measure(const Measurement &measured) override {
        const DepthView depth = measured.depth;
        // Where the camera's pose was lost, earlier maps have no place in the view any more.
        if (estimate_.source != FrameSource::estimated) {
            keyframes_.clear();
            now_ = Pose::identity();
        }
        Keyframe &k = keyframes_.push(now_);
        k.surface.build(depth, pool_);
        k.depth_from_world = now_;
        estimate_ = pipeline_->measure(measured);
        return estimate_;
    }

    void expect_lag(double lag_s) override { pipeline_->expect_lag(lag_s); }
    void prepare() override { pipeline_->prepare(); }
    void restart() override {
        pipeline_->restart();
        estimate_.source = FrameSource::none;
    }

private:
    /// Fits the newest keyframe's map to the true one and composes the depth map anew. False where
    /// the two do not fit.
    bool refine(const Pose &tracked) {
        const DepthRefinementOptions trust;
        Eigen::Matrix<float, 6, 6> information = Eigen::Matrix<float, 6, 6>::Zero();
        information.diagonal().head<3>().setConstant(1 / (trust.start_m * trust.start_m));
        information.diagonal().tail<3>().setConstant(1 / (trust.start_rad * trust.start_rad));
        const Keyframe &newest = keyframes_[0];
        const DepthFit fit =
            refine_by_depth(newest.surface, truth_, camera_, tracked, information, trust);
        if (!fit.good)
            return false;
        now_ = (fit.pose * newest.depth_from_world).normalized();
        composer_.compose(keyframes_, 0, now_, Alignment{}, Twist::Zero(),
                          camera_.width * camera_.height);
        composer_.judge({});
        return true;
    }

    Intrinsics camera_;
    KeyframeOptions options_;
    WorkerPool &pool_;
    std::unique_ptr<Pipeline> pipeline_;
    TruthAt truth_at_;
    KeyframeSet keyframes_;
    DepthSurface truth_;
    DepthComposer composer_;
    Pose now_; ///< world (the first measured frame) to camera
    Estimate estimate_;
};

} // namespace

PipelineFactory oracle_factory(const EstimatorOptions &options, WorkerPool &pool, TruthAt truth) {
    return [options, &pool, truth = std::move(truth)](const RigGeometry &geometry) {
        return std::make_unique<Oracle>(options, geometry.camera(), pool, truth);
    };
}

} // namespace afterglow
