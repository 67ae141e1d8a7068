// SPDX-License-Identifier: Apache-2.0
#include "core/keyframe/keyframe_pipeline.hpp"

#include <Eigen/Cholesky>

#include <algorithm>
#include <array>
#include <cassert>
#include <cmath>

namespace afterglow {
namespace {

/// Of an image gap no longer than this the last motion still tells something, seconds.
constexpr double longest_prediction_s = 0.5;
/// Maps are added until this share of what the last measured frame covered is covered.
constexpr float enough_coverage = 0.98f;
constexpr float least_fill = 0.05f;

using Matrix6f = Eigen::Matrix<float, 6, 6>;

/// Takes a motion (v, w) applied before `pose` to the same applied after it: v' = R v + T x R w and
/// w' = R w.
Matrix6f adjoint(const Pose &pose) {
    Matrix6f A = Matrix6f::Zero();
    A.topLeftCorner<3, 3>() = A.bottomRightCorner<3, 3>() = pose.R.cast<float>();
    for (int i = 0; i < 3; ++i)
        A.block<3, 1>(0, 3 + i) = pose.T.cross(pose.R.col(i)).cast<float>();
    return A;
}

} // namespace

KeyframePipeline::KeyframePipeline(const KeyframeOptions &options, const Intrinsics &camera,
                                   WorkerPool &pool)
    : camera_(camera), options_(options), pool_(pool), tracker_(options.alignment),
      keyframes_(options.compose.keyframes, camera, options.surface, options.alignment_template),
      image_(camera.width, camera.height, options.alignment_template.coarsest_level), previous_image_(image_),
      arriving_(camera, options.surface), bridge_(camera, options.surface, options.alignment_template),
      composer_(camera, options, pool), motion_mask_(camera, options.alignment),
      self_calibration_(options.self_calibration) {
    estimate_.depth = composer_.depth();
    estimate_.confidence = composer_.confidence();
}

const Estimate &KeyframePipeline::track(LumaView luma, std::int64_t t_ns) {
    assert(luma.width() == camera_.width && luma.height() == camera_.height);
    const double dt = 1e-9 * static_cast<double>(t_ns - t_ns_);
    t_ns_ = t_ns;
    std::swap(image_, previous_image_);
    image_.build(luma);
    estimate_.inliers = estimate_.matches = 0;
    estimate_.wants_measurement = true;
    if (keyframes_.size() == 0) {
        composer_.clear();
        publish(FrameSource::none);
        return estimate_;
    }
    ++estimate_.age_frames;
    align(dt);
    depth_now_ = moved_in(self_calibration_.correction().lag_s) * now_;
    composer_.compose(keyframes_, reference_, depth_now_, alignment_, enough_,
                      self_calibration_.correction());
    estimate_.matches = alignment_.points;
    estimate_.inliers = static_cast<int>(
        std::lround(alignment_.inlier_share * static_cast<float>(alignment_.points)));
    if (alignment_.good) {
        if (bridged_)
            motion_mask_.find(bridge_.alignment_template, image_, step_, composer_.depth());
        else
            motion_mask_.find(keyframes_[reference_].alignment_template, image_, alignment_,
                              composer_.depth());
        composer_.distrust(motion_mask_);
    } else {
        composer_.clear();
    }
    estimate_.wants_measurement = !alignment_.good;
    publish(alignment_.good ? FrameSource::estimated : FrameSource::none);
    return estimate_;
}

/// The keyframe that most of the predicted view is of; the newest, if about as much.
int KeyframePipeline::pick_reference(const Pose &predicted) const {
    int best = 0;
    float most = -1;
    for (int i = 0; i < keyframes_.size(); ++i) {
        const Pose pose = predicted * keyframes_[i].from_world.inverse();
        const float bonus = i == 0 ? options_.compose.newest_bonus / 100 : 0.0f;
        const float share = visible_share(keyframes_[i].surface, pose, camera_) + bonus;
        if (share > most) {
            most = share;
            best = i;
        }
    }
    return best;
}

/// Of the pose of an image taken `age_s` after another, and `dt` after the last, while the camera
/// turned at the rate `turning` then.
PosePrior KeyframePipeline::prior_of(const Pose &predicted, const Eigen::Vector3d &turning,
                                     double dt, double age_s) const {
    PosePrior prior;
    prior.skew_rad = options_.motion.readout_s * (static_cast<float>((turning_ - turning).norm()) +
                                                  options_.motion.angular_acceleration *
                                                      static_cast<float>(std::clamp(dt, 0.0, 0.1)));
    // Where the scene hardly tells a turn from a shift, the camera has rather turned.
    const float reach = options_.motion.speed * static_cast<float>(std::clamp(age_s, 0.01, 10.0));
    prior.mean = Pose{predicted.R, Eigen::Vector3d::Zero()};
    prior.information.topLeftCorner<3, 3>().diagonal().setConstant(1.0f / (reach * reach));
    return prior;
}

void KeyframePipeline::align(double dt) {
    const bool moving = velocity_s_ > 0 && dt > 0 && dt < longest_prediction_s;
    const Pose predicted = moving ? part_of(velocity_, dt / velocity_s_) * now_ : now_;
    reference_ = pick_reference(predicted);
    const Keyframe &k = keyframes_[reference_];
    const Pose to_world = k.from_world.inverse();
    const Pose turned{predicted.R, predicted.R * now_.R.transpose() * now_.T};
    const std::array<Pose, 3> starts{predicted * to_world, now_ * to_world, turned * to_world};

    const double age_s = 1e-9 * static_cast<double>(t_ns_ - k.t_ns);
    const PosePrior prior = prior_of(starts[0], k.turning, dt, age_s);
    alignment_ = tracker_.track(k.alignment_template, image_, starts, prior);

    const Pose before = now_;
    bridged_ = !alignment_.good && composer_.covered() > 0 && bridge(predicted, dt);
    if (alignment_.good)
        spread_ = alignment_.covariance;
    const bool usable = alignment_.points > 0 && alignment_.pose.is_finite();
    now_ = (usable ? alignment_.pose * k.from_world : predicted).normalized();
    velocity_ = alignment_.good ? now_ * before.inverse() : Pose::identity();
    velocity_s_ = std::max(dt, 0.0);
    turning_.setZero();
    if (dt > 0) {
        const Eigen::AngleAxisd turn(velocity_.R);
        turning_ = turn.axis() * (turn.angle() / dt);
    }
}

/// Where no keyframe can be aligned with any more, the image is aligned with the one before it and
/// the depth map composed for that, and the step is added to the last pose (Noraky & Sze 2019 Eq. 8). True
/// if that gave a pose; its covariance is that of all steps so far.
bool KeyframePipeline::bridge(const Pose &predicted, double dt) {
    bridge_.surface.build(composer_.depth(), pool_, self_calibration_.correction());
    bridge_.alignment_template.build(previous_image_, bridge_.surface);
    const std::array<Pose, 2> starts{predicted * now_.inverse(), Pose::identity()};
    step_ = tracker_.track(bridge_.alignment_template, image_, starts, prior_of(starts[0], turning_, dt, dt));
    if (!step_.good)
        return false;
    const Pose back = keyframes_[reference_].from_world * now_.inverse();
    const Matrix6f A = adjoint(back);
    alignment_ = step_;
    alignment_.skew.setZero();
    alignment_.pose = step_.pose * back.inverse();
    alignment_.covariance = spread_ + A * step_.covariance * A.transpose();
    return true;
}

const Estimate &KeyframePipeline::measure(DepthView depth) {
    assert(depth.width() == camera_.width && depth.height() == camera_.height);
    arriving_.build(depth, pool_, self_calibration_.correction());
    if (keyframes_.size() > 0) {
        const DepthFit fit = fit_to_reference(arriving_);
        if (fit.good) {
            depth_now_ = (fit.pose * keyframes_[reference_].depth_from_world).normalized();
            now_ = (moved_in(self_calibration_.correction().lag_s).inverse() * depth_now_).normalized();
        } else if (!alignment_.good)
            keyframes_.clear(); // where they are from here is not known any more
    }
    if (keyframes_.size() == 0) {
        now_ = depth_now_ = velocity_ = Pose::identity();
        composer_.clear();
    }
    Keyframe &k = keyframes_.push(depth_now_, camera_);
    std::swap(k.surface, arriving_);
    k.alignment_template.build(image_, k.surface);
    k.from_world = now_;
    k.depth_from_world = measured_from_world_ = depth_now_;
    k.t_ns = measured_ns_ = t_ns_;
    k.turning = turning_;
    spread_.setZero();
    fresh_fill_ = std::max(k.surface.fill(), least_fill);
    fresh_mre_ = 100 * fresh_error(k.surface);
    composer_.overlay(depth);
    enough_ = static_cast<int>(enough_coverage * static_cast<float>(composer_.covered()));
    estimate_.age_frames = 0;
    estimate_.wants_measurement = false;
    publish(FrameSource::measured);
    return estimate_;
}

/// Fits the pose of a new map to the reference keyframe by its geometry and what the images told.
DepthFit KeyframePipeline::fit_to_reference(const DepthSurface &fresh) {
    Matrix6f information = Matrix6f::Zero();
    if (alignment_.good) {
        const Matrix6f after = adjoint(alignment_.pose);
        Matrix6f spread = after * alignment_.covariance * after.transpose();
        spread.diagonal().array() += 1e-8f;
        information = spread.ldlt().solve(Matrix6f::Identity());
    }
    const Keyframe &k = keyframes_[reference_];
    const Pose start = depth_now_ * k.depth_from_world.inverse();
    const DepthFit fit = refine_by_depth(k.surface, fresh, camera_, start, information);
    if (fit.good && alignment_.good)
        calibrate(fit, start, information);
    return fit;
}

/// How the camera moves in so many seconds from now, at its present velocity.
Pose KeyframePipeline::moved_in(double seconds) const {
    return velocity_s_ > 0 ? part_of(velocity_, seconds / velocity_s_) : Pose::identity();
}

/// Learns the calibration from how the images say that the camera moved and what the maps measured.
void KeyframePipeline::calibrate(const DepthFit &fit, const Pose &start,
                                 const Matrix6f &information) {
    const Keyframe &k = keyframes_[reference_];
    const Eigen::Vector3d rate_change = turning_ - fit.pose.R * k.turning;
    self_calibration_.add(calibration_evidence(k.surface, arriving_, camera_, fit, start, information,
                                      rate_change, self_calibration_.correction().lag_s));
}

/// Mean relative error expected of a map's own pixels.
float KeyframePipeline::fresh_error(const DepthSurface &surface) const {
    constexpr int step = 8;
    const MapError error = map_error(surface, camera_, Pose::identity(),
                                     Eigen::Matrix<float, 6, 6>::Zero(), options_.error);
    double sum = 0;
    int count = 0;
    for (int v = 0; v < camera_.height; v += step)
        for (int u = 0; u < camera_.width; u += step) {
            const float z = surface.z()(u, v);
            const int distance = surface.edge_distance()(u, v);
            if (z == 0.0f || distance < options_.warp.least_edge_distance_px)
                continue;
            sum += pixel_error(error, options_.surface.noise, options_.error.shared_noise, z,
                               distance);
            ++count;
        }
    return count > 0 ? static_cast<float>(sum / count) : 0.0f;
}

/// Fills in what follows from the composed map.
void KeyframePipeline::publish(FrameSource source) {
    const float covered = static_cast<float>(composer_.covered()) /
                          static_cast<float>(camera_.width * camera_.height);
    estimate_.source = source;
    estimate_.coverage = 100 * covered;
    estimate_.relative_coverage = std::min(100 * covered / fresh_fill_, 100.0f);
    estimate_.expected_mre = composer_.expected_mre();
    estimate_.fresh_mre = fresh_mre_;
    estimate_.pose = (depth_now_ * measured_from_world_.inverse()).normalized();
    estimate_.age_ns = source == FrameSource::none ? 0 : t_ns_ - measured_ns_;
}

} // namespace afterglow
