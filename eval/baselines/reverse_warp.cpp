// SPDX-License-Identifier: Apache-2.0
#include "core/paper/paper_pipeline.hpp"
#include "eval/baselines/makers.hpp"

#include <algorithm>
#include <cmath>
#include <cstdint>

namespace afterglow {
namespace {

/// The paper's pipeline with each pixel of the new map fetched from the measured one, instead of
/// each measured pixel being sent to the new map (Noraky & Sze 2019, Section IV-C).
///
/// Where a pixel p comes from depends on its depth z, which is what is sought. It is found by
/// fixed-point iteration: with z as it stands p comes from q = project(pose^-1 back_project(p, z)),
/// and z becomes the depth that the pose gives the point measured at q. There are no holes, for
/// every p finds some q; also where p was hidden from the measurement, which is the method's fault.
class ReverseWarp final : public PaperPipeline {
public:
    ReverseWarp(const EstimatorOptions &options, const Intrinsics &camera, WorkerPool &pool)
        : PaperPipeline(options, camera, pool), pool_(pool) {}

private:
    void reproject(DepthView measured, const Pose &pose, ImageView<std::uint16_t> depth) override {
        pool_.run_strips(depth.height(), [&](int first, int end) {
            for (int v = first; v < end; ++v)
                fetch_row(measured, pose, v, depth.row(v));
        });
    }

    void fetch_row(DepthView measured, const Pose &pose, int v, std::uint16_t *row) const {
        const Pose back = pose.inverse();
        double guess = 0;
        for (int u = 0; u < measured.width(); ++u) {
            if (measured(u, v) != 0)
                guess = measured(u, v) / 1000.0; // and keep it across the sensor's holes
            const double z_mm = guess > 0 ? 1000 * fetch(measured, pose, back, u, v, guess) : 0;
            row[u] = static_cast<std::uint16_t>(z_mm < 65535.5 ? z_mm + 0.5 : 0);
        }
    }

    /// The depth in metres that pixel (u, v) has after `pose`, or 0 where nothing was measured.
    double fetch(DepthView measured, const Pose &pose, const Pose &back, int u, int v,
                 double guess) const {
        constexpr int iterations = 4;
        double z = guess;
        for (int i = 0; i < iterations; ++i) {
            const Eigen::Vector3d X = back * camera().back_project(u, v, z);
            if (!(X.z() > 0))
                return 0;
            const Eigen::Vector2d q = camera().project(X);
            if (!(q.cwiseAbs().maxCoeff() < 1e6))
                return 0;
            const int from_u = static_cast<int>(std::lround(q.x()));
            const int from_v = static_cast<int>(std::lround(q.y()));
            if (!measured.contains(from_u, from_v) || measured(from_u, from_v) == 0)
                return 0;
            const double from_z = measured(from_u, from_v) / 1000.0;
            z = (pose * camera().back_project(from_u, from_v, from_z)).z();
            if (!(z > 0))
                return 0;
        }
        return z;
    }

    WorkerPool &pool_;
};

} // namespace

std::unique_ptr<Pipeline> make_reverse_warp(const SystemInputs &inputs, const Intrinsics &camera) {
    return std::make_unique<ReverseWarp>(inputs.options, camera, inputs.pool);
}

} // namespace afterglow
