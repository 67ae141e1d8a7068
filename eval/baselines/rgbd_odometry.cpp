// SPDX-License-Identifier: Apache-2.0
#include "core/paper/published_frame.hpp"
#include "core/paper/reprojection.hpp"
#include "eval/baselines/makers.hpp"
#include "tools/picture/opencv_image.hpp"

#include <limits>
#include <opencv2/imgproc.hpp>
#include <opencv2/rgbd.hpp>
#include <vector>

namespace afterglow {
namespace {

using cv::rgbd::OdometryFrame;

/// Metres, on the four levels that RgbdOdometry uses by default. Every second pixel of a level
/// makes the next, as in its image pyramid but without averaging across edges and holes.
std::vector<cv::Mat> depth_pyramid(DepthView depth) {
    std::vector<cv::Mat> levels(4);
    as_mat(depth).convertTo(levels[0], CV_32F, 0.001);
    for (std::size_t i = 1; i < levels.size(); ++i) {
        const cv::Size size((levels[i - 1].cols + 1) / 2, (levels[i - 1].rows + 1) / 2);
        cv::resize(levels[i - 1], levels[i], size, 0, 0, cv::INTER_NEAREST);
    }
    for (cv::Mat &level : levels)
        level.setTo(std::numeric_limits<float>::quiet_NaN(), level == 0);
    return levels;
}

cv::Ptr<OdometryFrame> make_frame(const cv::Mat &luma, DepthView depth) {
    auto frame = OdometryFrame::create(luma.clone());
    frame->pyramidDepth = depth_pyramid(depth);
    return frame;
}

cv::Mat as_transform(const Pose &pose) {
    cv::Mat_<double> transform = cv::Mat_<double>::eye(4, 4);
    for (int i = 0; i < 3; ++i) {
        for (int j = 0; j < 3; ++j)
            transform(i, j) = pose.R(i, j);
        transform(i, 3) = pose.T(i);
    }
    return transform;
}

Pose as_pose(const cv::Mat_<double> &transform) {
    Pose pose;
    for (int i = 0; i < 3; ++i) {
        for (int j = 0; j < 3; ++j)
            pose.R(i, j) = transform(i, j);
        pose.T(i) = transform(i, 3);
    }
    return pose;
}

/// What a user would build from OpenCV instead: cv::rgbd::RgbdOdometry finds the pose of every
/// image against that of the last measured map, from the pose before, and the map is reprojected.
///
/// The odometry wants depth for both images, and there is none for the new one. It gets the map
/// reprojected to the pose before, as the source. The measured map is the destination: its pixels
/// are the ones that are followed, so that what is found does not rest on a reprojected depth.
class RgbdOdometry final : public Pipeline {
public:
    RgbdOdometry(const Intrinsics &camera, WorkerPool &pool)
        : odometry_(cv::rgbd::RgbdOdometry::create(cv::Mat(as_matrix(camera)))),
          reprojection_(camera, pool), frame_(camera), measured_(camera.width, camera.height),
          recent_(camera.width, camera.height) {
        odometry_->setMaxDepth(10); // by default it looks 4 m far, less than the recordings do
    }

    const Estimate &track(LumaView luma, std::int64_t t_ns) override {
        frame_.begin(t_ns);
        as_mat(luma).copyTo(luma_);
        if (!keyframe_ || !find_pose())
            return frame_.give_nothing();
        reprojection_.warp(measured_, frame_.estimate.pose, recent_);
        copy(recent_, frame_.depth());
        return frame_.give_estimated();
    }

    const Estimate &measure(const Measurement &measured) override {
        const DepthView depth = measured.depth;
        copy(depth, measured_);
        copy(depth, recent_);
        keyframe_ = make_frame(luma_, depth);
        return frame_.give_measured(depth);
    }
    void restart() override {
        keyframe_.reset();
        frame_.give_nothing();
    }

private:
    static void copy(DepthView from, ImageView<std::uint16_t> to) {
        as_mat(from).copyTo(as_mat(to));
    }

    /// Moves the estimate's pose to the new image; leaves it where it was if that fails.
    bool find_pose() {
        auto current = make_frame(luma_, recent_);
        Pose &pose = frame_.estimate.pose;
        cv::Mat to_keyframe;
        if (!odometry_->compute(current, keyframe_, to_keyframe, as_transform(pose.inverse())))
            return false;
        const Pose found = as_pose(to_keyframe).inverse();
        if (!found.is_finite())
            return false;
        pose = found;
        return true;
    }

    cv::Ptr<cv::rgbd::RgbdOdometry> odometry_;
    ForwardReprojection reprojection_;
    PublishedFrame frame_;
    DepthMap measured_;
    DepthMap recent_; ///< the last map that was measured or estimated
    cv::Mat luma_;
    cv::Ptr<OdometryFrame> keyframe_;
};

} // namespace

std::unique_ptr<Pipeline> make_rgbd_odometry(const SystemInputs &inputs, const Intrinsics &camera) {
    return std::make_unique<RgbdOdometry>(camera, inputs.pool);
}

} // namespace afterglow
