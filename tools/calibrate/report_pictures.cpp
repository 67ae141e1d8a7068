// SPDX-License-Identifier: Apache-2.0
#include "tools/calibrate/report_pictures.hpp"

#include "core/base/rgb.hpp"
#include "drivers/files/image_file.hpp"
#include "tools/calibrate/assessment.hpp"
#include "tools/calibrate/residuals.hpp"
#include "tools/picture/depth_colors.hpp"

#include <fmt/format.h>
#include <system_error>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <opencv2/imgproc.hpp>

namespace afterglow {
namespace {

const cv::Scalar white(245, 245, 245), green(200, 235, 200), lines(150, 150, 150),
    arrow(200, 40, 30), dot(30, 60, 160);

cv::Mat as_mat(Image<Rgb> &picture) {
    static_assert(sizeof(Rgb) == 3);
    return {picture.height(), picture.width(), CV_8UC3, picture.pixels().data()};
}

Image<Rgb> grey(LumaView image, int share) {
    Image<Rgb> picture(image.width(), image.height());
    for (int v = 0; v < image.height(); ++v)
        for (int u = 0; u < image.width(); ++u) {
            const auto luma = static_cast<std::uint8_t>(image(u, v) * share / 100);
            picture(u, v) = {luma, luma, luma};
        }
    return picture;
}

/// Small pictures are drawn larger.
int scale_of(const Intrinsics &camera) {
    return std::max(1, 640 / camera.width);
}

/// The cells that were seen, and the residuals of all corners.
Status write_residuals(const std::string &path, const CameraModel &camera, const Coverage &coverage,
                       const Board &board, std::span<const BoardView> views,
                       Corners BoardView::*corners, const RigFit &fit, const Pose &from_color) {
    const int scale = scale_of(camera.pinhole);
    const int width = camera.pinhole.width * scale, height = camera.pinhole.height * scale;
    Image<Rgb> picture(width, height);
    const cv::Mat drawing = as_mat(picture);
    for (int row = 0; row < Coverage::rows; ++row)
        for (int column = 0; column < Coverage::columns; ++column) {
            const cv::Rect cell(
                cv::Point(width * column / Coverage::columns, height * row / Coverage::rows),
                cv::Point(width * (column + 1) / Coverage::columns,
                          height * (row + 1) / Coverage::rows));
            cv::rectangle(drawing, cell, coverage.seen(column, row) ? green : white, cv::FILLED);
            cv::rectangle(drawing, cell, lines);
        }
    const std::vector<Eigen::Vector2d> places = board.corners();
    for (std::size_t k = 0; k < views.size(); ++k) {
        const Corners &seen = views[k].*corners;
        if (!fit.used[k] || seen.empty())
            continue;
        Eigen::VectorXd r(2 * static_cast<int>(seen.size()));
        corner_residuals(places, seen, camera, from_color * fit.board_to_color[k], 1, r);
        for (std::size_t i = 0; i < seen.size(); ++i) {
            const Eigen::Vector2d from = seen.pixels[i] * scale;
            const Eigen::Vector2d to =
                from + r.segment<2>(2 * static_cast<int>(i)) * scale * residual_magnification;
            const cv::Point begin(static_cast<int>(from.x()), static_cast<int>(from.y()));
            const cv::Point end(static_cast<int>(std::clamp(to.x(), -1e4, 1e4)),
                                static_cast<int>(std::clamp(to.y(), -1e4, 1e4)));
            cv::line(drawing, begin, end, arrow, 1, cv::LINE_AA);
            cv::circle(drawing, begin, 1, dot, cv::FILLED);
        }
    }
    return write_png(path, picture);
}

Status write_overlay(const std::string &path, LumaView image, DepthView depth, const RigFit &fit) {
    Image<Rgb> picture = grey(image, 60);
    const cv::Mat drawing = as_mat(picture);
    const DepthRange range = depth_range(depth);
    const int radius =
        std::max(1, static_cast<int>(0.35 * fit.rig.color.pinhole.fx / fit.rig.tof.pinhole.fx));
    const Pose color_from_tof = fit.rig.tof_from_color.inverse();
    for (int v = 0; v < depth.height(); ++v)
        for (int u = 0; u < depth.width(); ++u) {
            if (depth(u, v) == 0 || !fit.rig.tof.ray(u, v))
                continue;
            const DepthReading reading{static_cast<double>(u), static_cast<double>(v),
                                       depth(u, v) / 1000.0};
            const Eigen::Vector3d X =
                color_from_tof * point_of(reading, fit.rig.tof, fit.rig.range_along_ray);
            if (X.z() <= 0)
                continue;
            const Eigen::Vector2d at = fit.rig.color.project(X);
            const Rgb color = depth_color(depth(u, v), range.near_mm, range.far_mm);
            if (at.cwiseAbs().maxCoeff() < 1e4)
                cv::circle(drawing, {static_cast<int>(at.x()), static_cast<int>(at.y())}, radius,
                           cv::Scalar(color.red, color.green, color.blue), cv::FILLED);
        }
    // The image shows between the dots of depth.
    const Image<Rgb> below = grey(image, 100);
    for (std::size_t i = 0; i < picture.pixels().size(); ++i) {
        Rgb &pixel = picture.pixels()[i];
        const Rgb &under = below.pixels()[i];
        pixel = {static_cast<std::uint8_t>((pixel.red + under.red) / 2),
                 static_cast<std::uint8_t>((pixel.green + under.green) / 2),
                 static_cast<std::uint8_t>((pixel.blue + under.blue) / 2)};
    }
    return write_png(path, picture);
}

} // namespace

Status write_report_pictures(const std::string &folder, const Captures &captures,
                             const Board &board, std::span<const BoardView> views,
                             const RigFit &fit) {
    std::error_code problem;
    std::filesystem::create_directories(folder, problem);
    if (problem)
        return Error{fmt::format("{}: {}", folder, problem.message()), problem.value()};
    Status written =
        write_residuals(folder + "/color.png", fit.rig.color, color_coverage(fit, views), board,
                        views, &BoardView::color, fit, Pose::identity());
    if (written && fit.tof_noise_px > 0)
        written = write_residuals(folder + "/tof.png", fit.rig.tof, tof_coverage(fit, views), board,
                                  views, &BoardView::tof, fit, fit.rig.tof_from_color);
    if (!written)
        return written;
    // Where both cameras see the board, if the TOF camera has pictures.
    const std::size_t none = views.size();
    std::size_t nearest = none;
    for (std::size_t k = 0; k < views.size(); ++k)
        if (fit.used[k] && !views[k].color.empty() &&
            (fit.tof_noise_px == 0 || !views[k].tof.empty()) &&
            (nearest == none ||
             fit.board_to_color[k].T.norm() < fit.board_to_color[nearest].T.norm()))
            nearest = k;
    if (nearest == none)
        return ok();
    const Result<Luma> image = read_luma(captures.stills[nearest].color);
    return image ? write_overlay(folder + "/depth_on_color.png", *image, views[nearest].depth, fit)
                 : Status(image.error());
}

Status write_preview(const std::string &path, LumaView image, const Corners &corners) {
    Image<Rgb> picture = grey(image, 100);
    const cv::Mat drawing = as_mat(picture);
    for (const Eigen::Vector2d &pixel : corners.pixels)
        cv::circle(drawing, {static_cast<int>(pixel.x()), static_cast<int>(pixel.y())},
                   std::max(2, image.width() / 200), arrow, 2, cv::LINE_AA);
    return write_png(path, picture);
}

} // namespace afterglow
