// SPDX-License-Identifier: Apache-2.0
#include "core/keyframe_pipeline.hpp"

#include <Eigen/Cholesky>

#include <algorithm>
#include <array>
#include <cassert>
#include <cmath>

namespace afterglow {
namespace {

/// Of an image gap no longer than this the last motion still tells something, seconds.
constexpr double longest_prediction_s = 0.5;
/// Maps are added until this share of what a measurement would cover is covered.
constexpr float enough_coverage = 0.98f;
constexpr float least_fill = 0.05f;

} // namespace

KeyframePipeline::KeyframePipeline(const KeyframeOptions &options, const Intrinsics &camera,
                                   WorkerPool &pool)
    : camera_(camera), options_(options), pool_(pool), tracker_(options.alignment),
      keyframes_(options.compose.keyframes, camera, options.surface, options.texture),
      image_(camera.width, camera.height, options.texture.coarsest_level),
      arriving_(camera.width, camera.height, options.surface), composer_(camera, options, pool),
      motion_mask_(camera, options.alignment) {
    estimate_.depth = composer_.depth();
    estimate_.confidence = composer_.confidence();
}

const Estimate &KeyframePipeline::track(LumaView luma, std::int64_t t_ns) {
    assert(luma.width() == camera_.width && luma.height() == camera_.height);
    const double dt = 1e-9 * static_cast<double>(t_ns - t_ns_);
    t_ns_ = t_ns;
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
    const int enough = static_cast<int>(enough_coverage * fresh_fill_ *
                                        static_cast<float>(camera_.width * camera_.height));
    composer_.compose(keyframes_, reference_, now_, alignment_, enough);
    estimate_.matches = alignment_.points;
    estimate_.inliers = static_cast<int>(
        std::lround(alignment_.inlier_share * static_cast<float>(alignment_.points)));
    if (alignment_.good) {
        motion_mask_.find(keyframes_[reference_].texture, image_, alignment_, composer_.depth());
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

void KeyframePipeline::align(double dt) {
    const bool moving = velocity_s_ > 0 && dt > 0 && dt < longest_prediction_s;
    const Pose predicted = moving ? part_of(velocity_, dt / velocity_s_) * now_ : now_;
    reference_ = pick_reference(predicted);
    const Keyframe &k = keyframes_[reference_];
    const Pose to_world = k.from_world.inverse();
    const Pose turned{predicted.R, predicted.R * now_.R.transpose() * now_.T};
    const std::array<Pose, 3> starts{predicted * to_world, now_ * to_world, turned * to_world};

    PosePrior prior;
    prior.skew_rad =
        options_.motion.readout_s *
        (static_cast<float>((turning_ - k.turning).norm()) +
         options_.motion.angular_acceleration * static_cast<float>(std::clamp(dt, 0.0, 0.1)));
    // Where the scene hardly tells a turn from a shift, the camera has rather turned.
    const double age_s = std::clamp(1e-9 * static_cast<double>(t_ns_ - k.t_ns), 0.01, 10.0);
    const float reach = options_.motion.speed * static_cast<float>(age_s);
    prior.mean = Pose{starts[0].R, Eigen::Vector3d::Zero()};
    prior.information.topLeftCorner<3, 3>().diagonal().setConstant(1.0f / (reach * reach));
    alignment_ = tracker_.track(k.texture, image_, starts, prior);

    const Pose before = now_;
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

const Estimate &KeyframePipeline::measure(DepthView depth) {
    assert(depth.width() == camera_.width && depth.height() == camera_.height);
    arriving_.build(depth, pool_);
    if (keyframes_.size() > 0) {
        const DepthFit fit = fit_to_reference(arriving_);
        if (fit.good)
            now_ = (fit.pose * keyframes_[reference_].from_world).normalized();
        else if (!alignment_.good)
            keyframes_.clear(); // where they are from here is not known any more
    }
    if (keyframes_.size() == 0) {
        now_ = velocity_ = Pose::identity();
        composer_.clear();
    }
    Keyframe &k = keyframes_.push(now_, camera_);
    std::swap(k.surface, arriving_);
    k.texture.build(image_, k.surface);
    k.from_world = measured_from_world_ = now_;
    k.t_ns = measured_ns_ = t_ns_;
    k.turning = turning_;
    fresh_fill_ = std::max(k.surface.fill(), least_fill);
    fresh_mre_ = 100 * fresh_error(k.surface);
    composer_.overlay(depth);
    estimate_.age_frames = 0;
    estimate_.wants_measurement = false;
    publish(FrameSource::measured);
    return estimate_;
}

/// Fits the pose of a new map to the reference keyframe by its geometry and what the images told.
DepthFit KeyframePipeline::fit_to_reference(const DepthSurface &fresh) const {
    using Matrix6f = Eigen::Matrix<float, 6, 6>;
    Matrix6f information = Matrix6f::Zero();
    if (alignment_.good) {
        // The covariance is of a motion before the pose; of one after it, v' = R v + T x R w and
        // w' = R w.
        const Eigen::Matrix3f R = alignment_.pose.R.cast<float>();
        const Eigen::Vector3f T = alignment_.pose.T.cast<float>();
        Matrix6f after = Matrix6f::Zero();
        after.topLeftCorner<3, 3>() = after.bottomRightCorner<3, 3>() = R;
        for (int i = 0; i < 3; ++i)
            after.block<3, 1>(0, 3 + i) = T.cross(R.col(i));
        Matrix6f spread = after * alignment_.covariance * after.transpose();
        spread.diagonal().array() += 1e-8f;
        information = spread.ldlt().solve(Matrix6f::Identity());
    }
    const Keyframe &k = keyframes_[reference_];
    return refine_by_depth(k.surface, fresh, camera_, now_ * k.from_world.inverse(), information);
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
    estimate_.pose = (now_ * measured_from_world_.inverse()).normalized();
    estimate_.age_ns = source == FrameSource::none ? 0 : t_ns_ - measured_ns_;
}

} // namespace afterglow
