// SPDX-License-Identifier: Apache-2.0
//
// What a user would take from OpenCV instead, with OpenCV's own defaults or those of its samples,
// on one thread: how each image moved against the one before it.
//
//   lk144            pyramidal Lucas-Kanade at a uniform grid of 12 x 12 points
//   lk144+reproject  the same, and the keyframe's depth moved to the image pixel by pixel; the pose
//                    that a user would have to find from the points is given for nothing
//   dis, farneback   dense flow
//   rgbd             the pose by cv::rgbd::RgbdOdometry, with measured depth for both images, which
//                    a user whose TOF camera is dark has not got
#include "tools/bench/frame/benchmarks.hpp"
#include "tools/picture/opencv_image.hpp"

#include <Eigen/LU>

#include <algorithm>
#include <benchmark/benchmark.h>
#include <cstdint>
#include <functional>
#include <limits>
#include <opencv2/imgproc.hpp>
#include <opencv2/rgbd.hpp>
#include <opencv2/video/tracking.hpp>
#include <utility>
#include <vector>

namespace afterglow::bench {
namespace {

std::vector<cv::Point2f> grid(const Intrinsics &camera) {
    constexpr int side = 12;
    std::vector<cv::Point2f> points;
    for (int v = 0; v < side; ++v)
        for (int u = 0; u < side; ++u)
            points.emplace_back(
                (static_cast<float>(u) + 0.5f) * static_cast<float>(camera.width) / side,
                (static_cast<float>(v) + 0.5f) * static_cast<float>(camera.height) / side);
    return points;
}

/// Every pixel's point is moved by the pose and drawn at the pixel nearest to its projection; the
/// nearest point wins.
void reproject(const DepthMap &from, const Pose &pose, const Intrinsics &camera, DepthMap &to) {
    const Eigen::Matrix3f K = camera.matrix().cast<float>();
    const Eigen::Matrix3f turned = K * pose.R.cast<float>() * K.inverse();
    const Eigen::Vector3f moved = K * pose.T.cast<float>();
    std::ranges::fill(to.pixels(), std::uint16_t{0});
    for (int v = 0; v < from.height(); ++v) {
        for (int u = 0; u < from.width(); ++u) {
            const float z = static_cast<float>(from(u, v)) * 0.001f;
            if (z == 0)
                continue;
            const Eigen::Vector3f at =
                z * (turned * Eigen::Vector3f(static_cast<float>(u), static_cast<float>(v), 1)) +
                moved;
            if (at.z() <= 0)
                continue;
            const float x = at.x() / at.z() + 0.5f, y = at.y() / at.z() + 0.5f;
            if (!(x >= 0 && y >= 0 && x < static_cast<float>(to.width()) &&
                  y < static_cast<float>(to.height())))
                continue;
            std::uint16_t &pixel = to(static_cast<int>(x), static_cast<int>(y));
            const auto mm = static_cast<std::uint16_t>(std::min(1000 * at.z() + 0.5f, 65535.0f));
            if (pixel == 0 || mm < pixel)
                pixel = mm;
        }
    }
}

/// Calls `work` for each estimated frame.
using Work = std::function<void(const Stop &stop, std::size_t k)>;
void walk(benchmark::State &state, const Tour &tour, const Work &work) {
    const auto frames = static_cast<benchmark::IterationCount>(estimated_frames(tour));
    while (state.KeepRunningBatch(frames))
        for (const Stop &stop : tour)
            for (std::size_t k = 0; k < stop.size(); ++k)
                if (Stop::keyframe_of(k) != k)
                    work(stop, k);
}

void find_flow_lk(const Stop &stop, std::size_t k) {
    std::vector<cv::Point2f> to;
    std::vector<std::uint8_t> found;
    cv::calcOpticalFlowPyrLK(as_mat(stop[k - 1].luma), as_mat(stop[k].luma),
                             grid(stop.frames.camera), to, found, cv::noArray());
    benchmark::DoNotOptimize(to.data());
}

void lk(benchmark::State &state, const Tour &tour) {
    walk(state, tour, find_flow_lk);
}

void lk_and_reproject(benchmark::State &state, const Tour &tour) {
    DepthMap to;
    walk(state, tour, [&](const Stop &stop, std::size_t k) {
        find_flow_lk(stop, k);
        if (to.width() != stop[k].depth.width() || to.height() != stop[k].depth.height())
            to = DepthMap(stop[k].depth.width(), stop[k].depth.height());
        reproject(stop[Stop::keyframe_of(k)].depth, stop.poses[k], stop.frames.camera, to);
        benchmark::ClobberMemory();
    });
}

void dis(benchmark::State &state, const Tour &tour) {
    cv::Ptr<cv::DISOpticalFlow> dense;
    cv::Size of;
    cv::Mat flow;
    walk(state, tour, [&](const Stop &stop, std::size_t k) {
        // OpenCV 4.6 reads past its images when an instance meets another size.
        const cv::Size size = as_mat(stop[k].luma).size();
        if (size != of)
            dense = cv::DISOpticalFlow::create();
        of = size;
        dense->calc(as_mat(stop[k - 1].luma), as_mat(stop[k].luma), flow);
    });
}

void farneback(benchmark::State &state, const Tour &tour) {
    cv::Mat flow;
    walk(state, tour, [&](const Stop &stop, std::size_t k) {
        // As in OpenCV's samples/cpp/fback.cpp.
        cv::calcOpticalFlowFarneback(as_mat(stop[k - 1].luma), as_mat(stop[k].luma), flow, 0.5, 3,
                                     15, 3, 5, 1.2, 0);
    });
}

/// With depth in metres, none where there is none, as the odometry wants it.
cv::Ptr<cv::rgbd::OdometryFrame> odometry_frame(const DecodedFrame &frame) {
    const cv::Mat mm(frame.depth.height(), frame.depth.width(), CV_16UC1,
                     const_cast<std::uint16_t *>(frame.depth.row(0)));
    cv::Mat depth;
    mm.convertTo(depth, CV_32F, 0.001);
    depth.setTo(std::numeric_limits<float>::quiet_NaN(), mm == 0);
    return cv::rgbd::OdometryFrame::create(as_mat(frame.luma), depth);
}

void rgbd(benchmark::State &state, const Tour &tour) {
    cv::Ptr<cv::rgbd::RgbdOdometry> odometry;
    cv::Ptr<cv::rgbd::OdometryFrame> previous;
    const Stop *at = nullptr;
    walk(state, tour, [&](const Stop &stop, std::size_t k) {
        if (at != &stop || Stop::keyframe_of(k) == k - 1) {
            at = &stop;
            const Intrinsics &camera = stop.frames.camera;
            const cv::Matx33f matrix(
                static_cast<float>(camera.fx), 0, static_cast<float>(camera.cx), 0,
                static_cast<float>(camera.fy), static_cast<float>(camera.cy), 0, 0, 1);
            state.PauseTiming();
            odometry = cv::rgbd::RgbdOdometry::create(cv::Mat(matrix));
            previous = odometry_frame(stop[k - 1]);
            odometry->prepareFrameCache(previous, cv::rgbd::OdometryFrame::CACHE_ALL);
            state.ResumeTiming();
        }
        auto current = odometry_frame(stop[k]);
        cv::Mat motion;
        odometry->compute(previous, current, motion);
        previous = current;
    });
}

} // namespace

void register_opencv(const Tour &tour) {
    cv::setNumThreads(1);
    using Benchmark = void (*)(benchmark::State &, const Tour &);
    const std::pair<const char *, Benchmark> all[] = {{"opencv/lk144", lk},
                                                      {"opencv/lk144+reproject", lk_and_reproject},
                                                      {"opencv/dis", dis},
                                                      {"opencv/farneback", farneback},
                                                      {"opencv/rgbd", rgbd}};
    for (const auto &[name, function] : all)
        benchmark::RegisterBenchmark(
            name, [&tour, run = function](benchmark::State &state) { run(state, tour); });
}

} // namespace afterglow::bench
