// SPDX-License-Identifier: Apache-2.0
#include "config/parameter_table.hpp"
#include "config/sensor_profiles.hpp"

namespace afterglow {
namespace {

void add_paper(ParameterTable &table, EstimatorOptions &e) {
    table.section("flow", "Preset paper: sparse motion between two images by block matching.",
                  Method::paper);
    table.add("flow.grid", &e.flow.grid, {2, 64, "points"},
              "Points along each side of the uniform grid that is tracked; lower it to save time, "
              "raise it where few points have texture.");
    table.add("flow.block", &e.flow.block,
              {.minimum = 3, .maximum = 63, .unit = "pixels", .step = 2},
              "Side of the block compared around a point; raise it for noisy images, lower it near "
              "depth edges.");
    table.add("flow.step", &e.flow.step, {1, 64, "pixels"},
              "First step of the three-step search, halved down to 1; raise it for faster motion "
              "between two images.");
    table.section("ransac", "Preset paper: the pose from that motion.", Method::paper);
    table.add("ransac.draws", &e.ransac.draws, {1, 10000},
              "Pose hypotheses drawn for each image; raise it when many matches are wrong, lower "
              "it to save time.");
    table.add("ransac.hypothesis_iterations", &e.ransac.hypothesis_iterations, {1, 100},
              "Gauss-Newton steps on the 3 matches of a draw; raise it for large motion.");
    table.add("ransac.refine_iterations", &e.ransac.refine_iterations, {1, 100},
              "Gauss-Newton steps on the inliers of the best draw; raise it for large motion.");
    table.add(
        "ransac.threshold", &e.ransac.threshold, {0.01, 10000, "square pixels"},
        "Largest squared residual of an inlier; raise it for noisy or wrongly calibrated images.");
    table.add("ransac.min_inliers", &e.ransac.min_inliers, {0, 100, "percent"},
              "Share of the grid that an accepted pose must explain, below which a measurement is "
              "asked for; raise it for less error at a higher duty cycle.");
    table.add("ransac.seed", &e.ransac.seed, {0, 4294967295},
              "Seed of the draws, the same for the same depth; change it to see how much depends "
              "on chance.");
}

void add_keyframe(ParameterTable &table, KeyframeOptions &k, std::string &sensor_profile) {
    const Method method = Method::keyframe;
    table.section("motion", "Preset default: how the camera is moved.", method);
    table.add("motion.speed", &k.motion.speed, {0.001, 10, "m/s"},
              "How fast the camera is usually moved (one sigma); raise it for vehicles, lower it "
              "for a camera on a stand.");
    table.add("motion.angular_acceleration", &k.motion.angular_acceleration, {0, 10000, "rad/s^2"},
              "How fast the camera's turning rate usually changes (one sigma); raise it for shaken "
              "cameras.");
    table.add("motion.readout_s", &k.motion.readout_s, {0, 0.1, "s"},
              "Time from reading the first row of an image to the last; 0 for a global shutter, "
              "raise it for a slow rolling shutter.");
    table.section("self_calibration",
                  "Preset default: what may be wrong with the TOF camera's depth before it is "
                  "learnt from measurements.",
                  method);
    table.add("self_calibration.tilt", &k.self_calibration.tilt, {0, 0.3, "rad"},
              "Angle between the axes of the TOF camera and the colour camera (one sigma); 0 does "
              "not learn it, for cameras calibrated well.");
    table.add("self_calibration.curvature", &k.self_calibration.curvature, {0, 0.3},
              "Share by which depth is bent at 45 degrees off the axis (one sigma); 0 does not "
              "learn it, for cameras calibrated well.");
    table.add("self_calibration.lag_s", &k.self_calibration.lag_s, {0, 0.1, "s"},
              "Time between the exposures of an image and its depth map (one sigma); 0 does not "
              "learn it, for synchronised cameras.");
    table.add("self_calibration.pair_error", &k.self_calibration.pair_error,
              {0.1, 100, "of these sigmas"},
              "Systematic error of what one pair of depth maps tells of tilt and curvature; raise "
              "it to learn more slowly from more pairs.");
    table.add("self_calibration.lag_pair_error", &k.self_calibration.lag_pair_error,
              {0.1, 100, "of lag_s"},
              "Systematic error of what one pair of depth maps tells of the lag; raise it to learn "
              "more slowly from more pairs.");
    table.section(
        "sensor",
        "Preset default: noise and range of the TOF camera. `afterglowctl characterise` measures "
        "them.",
        method);
    table.add(
        "sensor.profile", &sensor_profile, {.choices = sensor_profile_names()},
        "Family of the TOF camera (docs/sensors.md), which decides the other keys of this table "
        "where they are not given.");
    table.add("sensor.floor_m", &k.surface.noise.floor_m, {-1, 1, "m"},
              "Constant term of the noise of a reading, sigma(z) = floor + linear z + quadratic "
              "z^2; set it for a camera that no profile fits.");
    table.add("sensor.linear", &k.surface.noise.linear, {-1, 1, "m/m"},
              "Term of the noise in z; set it as floor_m.");
    table.add("sensor.quadratic_per_m", &k.surface.noise.quadratic_per_m, {0, 1, "1/m"},
              "Term of the noise in z^2; set it as floor_m.");
    table.add(
        "sensor.least_relative", &k.surface.noise.least_relative, {0.0001, 0.1, "of depth"},
        "Least noise of any reading; raise it where the formula promises too little close by.");
    table.add("sensor.nearest_m", &k.surface.nearest_m, {0, 65, "m", "sensor.farthest_m"},
              "Nearer readings are ignored; raise it to the sensor's shortest range.");
    table.add("sensor.farthest_m", &k.surface.farthest_m, {0.1, warped_farthest_m, "m"},
              "Farther readings are ignored; set it to the sensor's longest range.");
    table.section("surface", "Preset default: a measured map is prepared for being warped.",
                  method);
    table.add("surface.edge_relative", &k.surface.edge_relative, {0.001, 1, "of depth"},
              "Step between neighbours that parts two surfaces; lower it when close objects merge "
              "with their background, raise it when slanted surfaces tear.");
    table.add("surface.smooth_radius_px", &k.surface.smooth_radius_px, {0, 8, "pixels"},
              "Half the window of the edge-preserving smoothing; raise it for a noisy sensor, 0 "
              "leaves maps as they are.");
    table.add("surface.crack_px", &k.surface.crack_px, {0, widest_crack_px, "pixels"},
              "Widest crack of a surface that is filled; 2 also fills holes of 3 pixels away from "
              "depth edges; lower it to publish only depth that was measured, 0 fills none.");
    table.section("template", "Preset default: which points of a keyframe images are aligned with.",
                  method);
    table.add(
        "template.points_per_level", &k.alignment_template.points_per_level,
        {100, 100000, "points"},
        "Most points of each pyramid level; lower it to save time, raise it for large images.");
    table.add("template.finest_level", &k.alignment_template.finest_level,
              {1, 6, "halvings", "template.coarsest_level"},
              "Finest pyramid level that is aligned; raise it to save time on large images.");
    table.add(
        "template.coarsest_level", &k.alignment_template.coarsest_level, {1, 6, "halvings"},
        "Coarsest pyramid level that is aligned; raise it for faster motion and larger images.");
    table.section("alignment", "Preset default: an image is aligned with a keyframe.", method);
    table.add("alignment.iterations_per_level", &k.alignment.iterations_per_level, {1, 100},
              "Most Gauss-Newton steps on a pyramid level; raise it when fast motion is lost, "
              "lower it to save time.");
    table.add(
        "alignment.pixel_noise", &k.alignment_template.pixel_noise, {0.1, 50, "grey values"},
        "Noise of a well-exposed image (one sigma), of which a dim image has a share; raise it for "
        "small sensors.");
    table.add("alignment.blur_px", &k.alignment_template.blur_px, {0, 5, "pixels"},
              "Uncertainty of where a gradient is (one sigma); raise it for blurred images.");
    table.add("alignment.independent_share", &k.alignment.independent_share,
              {0.0001, 1, "of the points"},
              "Share of the points whose errors are independent; lower it when the expected error "
              "is too small, raise it when too large.");
    table.add(
        "alignment.least_inlier_share", &k.alignment.least_inlier_share, {0, 1, "of the points"},
        "A pose that fewer points agree with is rejected; lower it where much of the scene moves.");
    table.add("alignment.least_correlation", &k.alignment.least_correlation, {0, 1},
              "A pose at which the image correlates less with the keyframe is rejected; lower it "
              "for changing light.");
    table.add(
        "alignment.least_points", &k.alignment.least_points, {12, 100000, "points"},
        "A pose with fewer points in view is rejected; lower it for scenes with little texture.");
    table.section("warp", "Preset default: a map is warped to the present view.", method);
    table.add("warp.least_edge_distance_px", &k.warp.least_edge_distance_px, {1, 7, "pixels"},
              "Readings nearer to a depth edge are left out; raise it when wrong depth surrounds "
              "objects, 1 keeps all for more coverage.");
    table.section("compose", "Preset default: several measured maps make one.", method);
    table.add("compose.keyframes", &k.compose.keyframes, {1, 16, "maps"},
              "Measured maps that are kept; raise it where the camera returns to what it has seen, "
              "lower it to save memory.");
    table.add("compose.maps_per_frame", &k.compose.maps_per_frame, {1, 16, "maps"},
              "Most maps warped into one frame; raise it for more coverage, by pixels that are "
              "several times as wrong as the newest map's.");
    table.add("compose.newest_bonus", &k.compose.newest_bonus, {0, 100, "percent"},
              "An earlier map is aligned with only if this much more of it is in view; raise it "
              "when depth jumps as the map changes.");
    table.add(
        "compose.follow_moving", &k.compose.follow_moving, {},
        "The depth of things that move by themselves is moved along with them in the picture; "
        "turn it off to save processor time: moving parts of the picture then have no depth.");
    table.section("error",
                  "Preset default: what error of a warped map is expected, which the gate acts on. "
                  "`afterglow-eval run` tells how well it fits.",
                  method);
    table.add("error.lag_jitter_s", &k.error.lag_jitter_s, {0, 0.1, "s"},
              "Jitter of the lag from an image to its depth map, one sigma: the expected error of "
              "a moving camera's maps grows with it. Raise it for stamps that jitter more; 0 where "
              "hardware triggers both cameras.");
    table.add("error.edge_registration_px", &k.error.edge_registration_px, {0, 20, "pixels"},
              "Misplacement of depth edges in measured maps (one sigma); raise it for a poor "
              "registration of the two cameras.");
    table.add("error.shared_noise", &k.error.shared_noise, {0, 1, "of sigma"},
              "Part of the sensor's noise that smoothing leaves; lower it when "
              "surface.smooth_radius_px is raised.");
    table.add("error.moving_error", &k.error.moving_error, {0, 1, "of depth"},
              "Error that the gate assumes of a pixel that has no depth because something moves "
              "there; raise it when moving things should be measured more often.");
}

void add_gate(ParameterTable &table, GatePolicy &gate) {
    // In the order of enum GateMode.
    static constexpr std::string_view modes[] = {"auto", "always-on", "interval", "off"};
    const Method predicting = Method::keyframe; // the paper's pipeline predicts no error
    table.section("gate", "When the TOF camera is lit.");
    table.add("gate.mode", &gate.mode, {.choices = modes},
              "auto lights when the depth expected of the estimates is not good enough, by the "
              "keys below; choose always-on to measure every frame, interval to measure one frame "
              "in interval_frames, off to keep the light dark.");
    table.add("gate.interval_frames", &gate.interval_frames, {1, 100000, "frames"},
              "Mode interval: from one measurement to the next; lower it for less error at a "
              "higher duty cycle.");
    table.add(
        "gate.target_mre", &gate.target_mre, {0.01, 100, "percent"},
        "Mode auto: an expected mean relative error above it is measured away, where that helps; "
        "afterglow-eval counts frames above it; lower it for better depth at a higher duty "
        "cycle.");
    table.add(
        "gate.measurement_price", &gate.measurement_price, {0, 100000, "frames"},
        "Mode auto, preset default: what a measurement costs, as a number of frames at the target "
        "error; raise it to save light, lower it for smaller errors.");
    table.add(
        "gate.worthwhile", &gate.worthwhile, {1, 100, "percent"},
        "Mode auto, preset default: a measurement is made for the error only if it is expected to "
        "lower it to this share or less; raise it when the target is missed although the "
        "light is dark.",
        predicting);
    table.add("gate.coverage_floor", &gate.coverage_floor, {0, 100, "percent"},
              "Mode auto, preset default: least share of what a measurement would cover; raise it "
              "for more coverage at a higher duty cycle.",
              predicting);
    table.add("gate.shortest_interval_frames", &gate.shortest_interval_frames,
              {1, 100000, "frames", "gate.longest_interval_frames"},
              "Mode auto: least distance of two measurements; raise it to limit how often the "
              "light switches.");
    table.add("gate.longest_interval_frames", &gate.longest_interval_frames, {1, 100000, "frames"},
              "Mode auto: greatest distance of two measurements; lower it where depth must never "
              "be old.");
    table.add("gate.duty_cycle_budget", &gate.duty_cycle_budget, {0.01, 100, "percent"},
              "Frames lit in the long run, at most, whatever mode and clients want; lower it to "
              "guarantee battery life, 100 = no budget.");
    table.add("gate.budget_burst", &gate.budget_burst, {1, 1000, "frames"},
              "Lit frames that the budget lets be saved up; raise it for long bursts of motion.");
}

} // namespace

void add_estimator_parameters(ParameterTable &table, Config &config) {
    add_paper(table, config.estimator);
    add_keyframe(table, config.estimator.keyframe, config.sensor_profile);
    add_gate(table, config.gate);
}

} // namespace afterglow
