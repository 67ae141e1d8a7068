// SPDX-License-Identifier: Apache-2.0
#include "tools/calibrate/camera_fit.hpp"

#include "config/calibration_limits.hpp"
#include "core/base/degrees.hpp"
#include "tools/calibrate/least_squares.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <opencv2/calib3d.hpp>

namespace afterglow {
namespace {

/// From simple to rich.
constexpr std::array<LensModel, 4> models = {{{Lens::brown_conrady, 4},
                                              {Lens::kannala_brandt, 4},
                                              {Lens::brown_conrady, 5},
                                              {Lens::brown_conrady, 8}}};
constexpr double as_good = 1.03; ///< residuals up to so many times the best ones
/// Below it all views look alike, and focal length and distance cannot be told apart; degrees.
constexpr double least_tilt = 12;
constexpr std::size_t fewest_lens_views = 6;

/// A first idea of the focal length: by the homographies, as if there were no lens.
CameraModel first_guess(const Board &board, std::span<const Corners> views, int width, int height) {
    const std::vector<Eigen::Vector2d> places = board.corners();
    std::vector<std::vector<cv::Point3f>> objects;
    std::vector<std::vector<cv::Point2f>> pictures;
    for (const Corners &view : views) {
        objects.emplace_back();
        pictures.emplace_back();
        for (std::size_t i = 0; i < view.size(); ++i) {
            const Eigen::Vector2d &place = places[static_cast<std::size_t>(view.numbers[i])];
            objects.back().emplace_back(static_cast<float>(place.x()),
                                        static_cast<float>(place.y()), 0.0F);
            pictures.back().emplace_back(static_cast<float>(view.pixels[i].x()),
                                         static_cast<float>(view.pixels[i].y()));
        }
    }
    const cv::Mat K = cv::initCameraMatrix2D(objects, pictures, {width, height}, 1);
    double f = K.at<double>(0, 0);
    if (!(f > 0.2 * width && f < 4 * width))
        f = 0.8 * width;
    return {{f, f, (width - 1) / 2.0, (height - 1) / 2.0, width, height}};
}

/// From coarse to fine: at first nearly every corner is an outlier.
CameraFit fit_model(const Board &board, std::span<const Corners> views, const LensModel &model,
                    const CameraModel &guess, const std::vector<Pose> &poses) {
    const std::vector<Eigen::Vector2d> places = board.corners();
    const int width = guess.pinhole.width, height = guess.pinhole.height;
    Eigen::VectorXd x(model.parameters() + 6 * static_cast<int>(views.size()));
    x.head(model.parameters()) = to_parameters(guess, model);
    for (std::size_t k = 0; k < views.size(); ++k)
        x.segment<6>(model.parameters() + 6 * static_cast<int>(k)) = log(poses[k]);
    const CameraUnknowns unknowns{model, width, height};
    double noise = 0.02 * width;
    LeastSquaresFit solved;
    for (int round = 0; round < 4; ++round) {
        std::vector<ResidualBlock> blocks;
        for (std::size_t k = 0; k < views.size(); ++k)
            blocks.push_back(corner_block(places, views[k], unknowns,
                                          model.parameters() + 6 * static_cast<int>(k), noise));
        solved = least_squares(x, blocks, 40);
        x = solved.x;
        noise = std::max(noise * noise_of(x, blocks), least_noise_px);
    }
    CameraFit fit{model,
                  to_camera(x.head(model.parameters()), model, width, height),
                  {},
                  noise,
                  solved.sigma.head<2>().maxCoeff() / x[0],
                  solved.sigma.segment<2>(2).maxCoeff()};
    for (std::size_t k = 0; k < views.size(); ++k)
        fit.board_to_camera.push_back(
            exp(x.segment<6>(model.parameters() + 6 * static_cast<int>(k))));
    return fit;
}

/// What is wrong with it; "" where nothing is.
std::string implausible(const CameraFit &fit) {
    const Intrinsics &camera = fit.camera.pinhole;
    if (!(camera.fx > 0.1 * camera.width && camera.fx < 10 * camera.width))
        return fmt::format("a focal length of {:.0f} pixels", camera.fx);
    const auto problem = problem_of(fit.camera);
    return problem ? fmt::format("{}: {}", problem->key, problem->sentence) : std::string();
}

} // namespace

std::optional<Pose> board_pose(const Board &board, const Corners &corners,
                               const CameraModel &camera) {
    const std::vector<Eigen::Vector2d> places = board.corners();
    std::vector<cv::Point3d> objects;
    std::vector<cv::Point2d> rays;
    for (std::size_t i = 0; i < corners.size(); ++i) {
        const auto ray = camera.ray(corners.pixels[i].x(), corners.pixels[i].y());
        if (!ray)
            continue;
        const Eigen::Vector2d &place = places[static_cast<std::size_t>(corners.numbers[i])];
        objects.emplace_back(place.x(), place.y(), 0);
        rays.emplace_back(ray->x(), ray->y());
    }
    if (objects.size() < 4)
        return std::nullopt;
    cv::Vec3d turn, shift;
    if (!cv::solvePnP(objects, rays, cv::Matx33d::eye(), cv::noArray(), turn, shift, false,
                      cv::SOLVEPNP_IPPE))
        return std::nullopt;
    const Pose pose{rotation({turn[0], turn[1], turn[2]}), {shift[0], shift[1], shift[2]}};
    return pose.is_finite() && pose.T.z() > 0 ? std::optional(pose) : std::nullopt;
}

Result<CameraFit> fit_camera(const Board &board, std::span<const Corners> views, int width,
                             int height, const std::optional<Lens> &wanted) {
    if (views.size() < fewest_lens_views)
        return Error{fmt::format("the board was found in {} of its pictures; {} are the least, "
                                 "and 20 a good number",
                                 views.size(), fewest_lens_views)};
    const CameraModel guess = first_guess(board, views, width, height);
    std::vector<Pose> poses;
    for (const Corners &view : views) {
        const auto pose = board_pose(board, view, guess);
        poses.push_back(pose ? *pose : Pose{Eigen::Matrix3d::Identity(), {0, 0, 1}});
    }
    if (const double tilt = tilt_range(poses); tilt < least_tilt)
        return Error{fmt::format("all views show the board at nearly the same angle (within {:.0f} "
                                 "degrees; 40 are good): focal length and distance cannot be told "
                                 "apart. Tilt it to the left, right, up and down",
                                 tilt)};
    std::vector<CameraFit> fits;
    std::string problem = "no lens";
    for (const LensModel &model : models) {
        if (wanted && *wanted != model.lens)
            continue;
        CameraFit fit = fit_model(board, views, model, guess, poses);
        if (std::string wrong = implausible(fit); wrong.empty())
            fits.push_back(std::move(fit));
        else
            problem = fmt::format("{} would need {}", to_text(model), wrong);
    }
    if (fits.empty())
        return Error{fmt::format("no camera explains the pictures: {}. Take more views, up to the "
                                 "corners of the picture, and tilted",
                                 problem)};
    const double best =
        std::min_element(fits.begin(), fits.end(), [](const auto &a, const auto &b) {
            return a.noise_px < b.noise_px;
        })->noise_px;
    return *std::find_if(fits.begin(), fits.end(),
                         [&](const CameraFit &fit) { return fit.noise_px <= as_good * best; });
}

double tilt_range(std::span<const Pose> board_to_camera) {
    double cosine = 1;
    for (std::size_t i = 0; i < board_to_camera.size(); ++i)
        for (std::size_t k = 0; k < i; ++k)
            cosine = std::min(cosine, board_to_camera[i].R.col(2).dot(board_to_camera[k].R.col(2)));
    return std::acos(std::clamp(cosine, -1.0, 1.0)) * degrees_per_radian;
}

} // namespace afterglow
