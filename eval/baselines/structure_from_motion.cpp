// SPDX-License-Identifier: Apache-2.0
#include "core/paper/published_frame.hpp"
#include "eval/baselines/keypoints.hpp"
#include "eval/baselines/makers.hpp"
#include "eval/baselines/two_view.hpp"

#include <algorithm>
#include <utility>

namespace afterglow {
namespace {

/// Structure from motion of each image and the one before (Noraky & Sze 2019, Section VI-C2): depth
/// at the keypoints that both see, in the unknown unit of the way between them, scaled to the
/// truth. Needs no TOF camera, and never asks for one.
class StructureFromMotion final : public Pipeline {
public:
    using Finder = Keypoints(LumaView);

    StructureFromMotion(const Intrinsics &camera, Finder *find_keypoints, TruthAt truth)
        : camera_(camera), find_keypoints_(find_keypoints), truth_at_(std::move(truth)),
          frame_(camera) {}

    const Estimate &track(LumaView luma, std::int64_t t_ns) override {
        frame_.begin(t_ns);
        Keypoints keypoints = find_keypoints_(luma);
        const auto pairs = match_keypoints(previous_, keypoints);
        previous_ = std::move(keypoints);
        const auto points = triangulate(pairs, camera_);
        const auto truth = truth_at_(t_ns);
        const auto scale = truth ? fit_scale(points, *truth) : std::nullopt;
        if (scale)
            draw(points, *scale);
        scale ? frame_.give_estimated() : frame_.give_nothing();
        Estimate &e = frame_.estimate;
        e.matches = static_cast<int>(pairs.size());
        e.inliers = static_cast<int>(points.size());
        e.age_frames = 0; // it rests on no measurement
        e.age_ns = 0;
        e.wants_measurement = false;
        return e;
    }

    const Estimate &measure(const Measurement &measured) override {
        return frame_.give_measured(measured.depth);
    }
    void restart() override {
        previous_ = {};
        frame_.give_nothing();
    }

private:
    /// Of several points in a pixel the nearest wins.
    void draw(std::span<const ScenePoint> points, double scale) {
        DepthMap &depth = frame_.depth();
        std::ranges::fill(depth.pixels(), std::uint16_t{0});
        for (const ScenePoint &point : points) {
            const auto at = pixel_of(point, depth.width(), depth.height());
            if (!at)
                continue;
            // What lies beyond the map's range is drawn at its end: to drop it would hide an error.
            const auto z_mm =
                static_cast<std::uint16_t>(std::clamp(1000 * scale * point.z + 0.5, 1.0, 65535.0));
            std::uint16_t &pixel = depth(at->x(), at->y());
            pixel = pixel == 0 ? z_mm : std::min(pixel, z_mm);
        }
    }

    Intrinsics camera_;
    Finder *find_keypoints_;
    TruthAt truth_at_;
    PublishedFrame frame_;
    Keypoints previous_;
};

} // namespace

std::unique_ptr<Pipeline> make_sfm_sift(const SystemInputs &inputs, const Intrinsics &camera) {
    return std::make_unique<StructureFromMotion>(camera, find_sift_keypoints, inputs.truth);
}

std::unique_ptr<Pipeline> make_sfm_surf(const SystemInputs &inputs, const Intrinsics &camera) {
    return std::make_unique<StructureFromMotion>(camera, find_surf_keypoints, inputs.truth);
}

std::unique_ptr<Pipeline> make_sfm_orb(const SystemInputs &inputs, const Intrinsics &camera) {
    return std::make_unique<StructureFromMotion>(camera, find_orb_keypoints, inputs.truth);
}

} // namespace afterglow
