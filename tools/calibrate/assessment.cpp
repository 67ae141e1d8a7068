// SPDX-License-Identifier: Apache-2.0
#include "tools/calibrate/assessment.hpp"

#include "core/base/degrees.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

namespace afterglow {
namespace {

double degrees(double radians) {
    return radians * degrees_per_radian;
}

Coverage coverage_of(const Intrinsics &camera, const RigFit &fit, std::span<const BoardView> views,
                     Corners BoardView::*corners) {
    Coverage coverage(camera.width, camera.height);
    for (std::size_t k = 0; k < views.size(); ++k)
        if (fit.used[k])
            coverage.add(views[k].*corners);
    return coverage;
}

/// Collects what is not good.
class Judge {
public:
    /// `value` is good up to one limit and usable up to another.
    void at_most(double value, double good, double usable, const std::string &reason) {
        if (value <= good)
            return;
        // What is not a number is not usable either.
        const Verdict verdict = value <= usable ? Verdict::usable : Verdict::not_usable;
        assessment_.verdict = std::max(assessment_.verdict, verdict);
        assessment_.reasons.push_back(reason);
    }
    void at_least(double value, double good, double usable, const std::string &reason) {
        at_most(-value, -good, -usable, reason);
    }
    const Assessment &assessment() const { return assessment_; }

private:
    Assessment assessment_;
};

void judge_camera(Judge &judge, const char *name, double noise_px, double focal, double center_px,
                  const Intrinsics &camera) {
    judge.at_most(noise_px, 0.3, 1,
                  fmt::format("{} camera: corners are {:.2f} pixels from where they should be: is "
                              "the board flat, are pictures sharp, was it held still?",
                              name, noise_px));
    judge.at_most(focal, 0.0015, 0.01,
                  fmt::format("{} camera: the focal length is known to {:.2f} percent: take more "
                              "views, with the board tilted by 30 to 45 degrees",
                              name, 100 * focal));
    judge.at_most(center_px / camera.width, 0.0025, 0.015,
                  fmt::format("{} camera: the principal point is known to {:.1f} pixels: take more "
                              "views, with the board tilted and in all parts of the picture",
                              name, center_px));
}

} // namespace

const char *to_text(Verdict verdict) {
    switch (verdict) {
    case Verdict::good:
        return "good";
    case Verdict::usable:
        return "usable";
    case Verdict::not_usable:
        break;
    }
    return "not usable";
}

Coverage color_coverage(const RigFit &fit, std::span<const BoardView> views) {
    return coverage_of(fit.rig.color.pinhole, fit, views, &BoardView::color);
}
Coverage tof_coverage(const RigFit &fit, std::span<const BoardView> views) {
    return coverage_of(fit.rig.tof.pinhole, fit, views, &BoardView::tof);
}

Assessment assess(const RigFit &fit, const Board &board, std::span<const BoardView> views,
                  const std::optional<TimingFit> &timing) {
    Judge judge;
    const RigSigma &sigma = fit.sigma;
    judge_camera(judge, "colour", fit.color_noise_px, sigma.color_focal, sigma.color_center_px,
                 fit.rig.color.pinhole);
    judge_camera(judge, "TOF", fit.tof_noise_px, sigma.tof_focal, sigma.tof_center_px,
                 fit.rig.tof.pinhole);
    const double color_seen = color_coverage(fit, views).share();
    judge.at_least(color_seen, 0.7, 0.4,
                   fmt::format("colour camera: the board was seen in {:.0f} percent of the view: "
                               "the lens is not known where it was not, hold it there",
                               100 * color_seen));
    const double tof_seen = tof_coverage(fit, views).share();
    if (tof_seen > 0)
        judge.at_least(tof_seen, 0.6, 0.3,
                       fmt::format("TOF camera: the board was seen in {:.0f} percent of the view: "
                                   "hold it where it was not",
                                   100 * tof_seen));
    std::vector<Pose> poses;
    for (std::size_t k = 0; k < fit.board_to_color.size(); ++k)
        if (fit.used[k])
            poses.push_back(fit.board_to_color[k]);
    const double tilt = tilt_range(poses);
    judge.at_least(tilt, 40, 20,
                   fmt::format("the boards' angles are within {:.0f} degrees of each other: tilt "
                               "the board further, to all sides",
                               tilt));
    judge.at_most(1000 * sigma.translation_m, 1.5, 8,
                  fmt::format("the TOF camera's place is known to {:.1f} mm: take more views in "
                              "which both cameras see the board",
                              1000 * sigma.translation_m));
    judge.at_most(degrees(sigma.rotation_rad), 0.12, 0.6,
                  fmt::format("the TOF camera's direction is known to {:.2f} degrees: take more "
                              "views in which both cameras see the board",
                              degrees(sigma.rotation_rad)));
    if (fit.depth_scale)
        judge.at_most(std::abs(*fit.depth_scale - 1), 0.015, 0.03,
                      fmt::format("the TOF camera measures {:.1f} percent of the board's distance: "
                                  "if its depth is right, a side of the board has {:.2f} mm and "
                                  "not {:.2f} mm. Measure the board with a ruler",
                                  100 * *fit.depth_scale, 1000 * board.side_m * *fit.depth_scale,
                                  1000 * board.side_m));
    if (!timing) {
        judge.at_most(1, 0, 1,
                      "no moving board was recorded: the delay between images and depth maps, and "
                      "the read-out time, are taken to be 0");
    } else {
        judge.at_most(1000 * timing->tof_delay_sigma_s, 1, 5,
                      fmt::format("the delay is known to {:.1f} ms: move the board faster",
                                  1000 * timing->tof_delay_sigma_s));
        judge.at_most(1000 * timing->readout_sigma_s, 1, 5,
                      fmt::format("the read-out time is known to {:.1f} ms: move the board faster, "
                                  "over the whole height of the picture",
                                  1000 * timing->readout_sigma_s));
    }
    return judge.assessment();
}

} // namespace afterglow
