// SPDX-License-Identifier: Apache-2.0
#include "tools/calibrate/residuals.hpp"

#include "core/base/median.hpp"

#include <fmt/format.h>

#include <cmath>
#include <utility>

namespace afterglow {

std::string to_text(const LensModel &model) {
    const char *name = model.lens == Lens::brown_conrady    ? "brown-conrady"
                       : model.lens == Lens::kannala_brandt ? "kannala-brandt"
                                                            : "pinhole";
    return model.coefficients == 0
               ? name
               : fmt::format("{} with {} coefficients", name, model.coefficients);
}

Eigen::VectorXd to_parameters(const CameraModel &camera, const LensModel &model) {
    Eigen::VectorXd x(model.parameters());
    x.head<4>() << camera.pinhole.fx, camera.pinhole.fy, camera.pinhole.cx, camera.pinhole.cy;
    for (int i = 0; i < model.coefficients; ++i)
        x[4 + i] = camera.distortion[static_cast<std::size_t>(i)];
    return x;
}

CameraModel to_camera(const Eigen::Ref<const Eigen::VectorXd> &x, const LensModel &model, int width,
                      int height) {
    CameraModel camera{{x[0], x[1], x[2], x[3], width, height}, model.lens};
    for (int i = 0; i < model.coefficients; ++i)
        camera.distortion[static_cast<std::size_t>(i)] = x[4 + i];
    return camera;
}

std::vector<int> CameraUnknowns::free_parameters(int pose_at) const {
    std::vector<int> free;
    const auto add = [&](int first, int count) {
        for (int i = 0; i < count; ++i)
            free.push_back(first + i);
    };
    if (!is_known)
        add(at, model.parameters());
    if (extrinsics_at >= 0)
        add(extrinsics_at, 6);
    add(pose_at, 6);
    return free;
}

void corner_residuals(const std::vector<Eigen::Vector2d> &places, const Corners &corners,
                      const CameraModel &camera, const Pose &pose, double noise_px,
                      Eigen::Ref<Eigen::VectorXd> r) {
    for (std::size_t i = 0; i < corners.size(); ++i) {
        const Eigen::Vector2d &place = places[static_cast<std::size_t>(corners.numbers[i])];
        const Eigen::Vector3d X = pose * Eigen::Vector3d(place.x(), place.y(), 0);
        r.segment<2>(2 * static_cast<int>(i)) = (camera.project(X) - corners.pixels[i]) / noise_px;
    }
}

ResidualBlock corner_block(const std::vector<Eigen::Vector2d> &places, const Corners &corners,
                           const CameraUnknowns &unknowns, int pose_at, double noise_px) {
    return {unknowns.free_parameters(pose_at), 2 * static_cast<int>(corners.size()),
            [&places, &corners, unknowns, pose_at, noise_px](const Eigen::VectorXd &x,
                                                             Eigen::Ref<Eigen::VectorXd> r) {
                const Pose pose = unknowns.from_color(x) * exp(Twist(x.segment<6>(pose_at)));
                corner_residuals(places, corners, unknowns.camera(x), pose, noise_px, r);
            }};
}

Eigen::Vector3d point_of(const DepthReading &reading, const CameraModel &camera,
                         bool range_along_ray) {
    const Eigen::Vector2d ray = camera.ray(reading.u, reading.v).value_or(Eigen::Vector2d::Zero());
    const Eigen::Vector3d X(ray.x(), ray.y(), 1);
    return X * (range_along_ray ? reading.m / X.norm() : reading.m);
}

void plane_residuals(std::span<const DepthReading> readings, const CameraModel &camera,
                     bool range_along_ray, const Pose &pose, double noise_m, double scale,
                     Eigen::Ref<Eigen::VectorXd> r) {
    const Eigen::Vector3d normal = pose.R.col(2);
    const double distance = normal.dot(pose.T);
    for (std::size_t i = 0; i < readings.size(); ++i) {
        DepthReading unit = readings[i];
        unit.m = 1;
        const double expected = distance / normal.dot(point_of(unit, camera, range_along_ray));
        r[static_cast<int>(i)] = (scale * readings[i].m - expected) / noise_m;
    }
}

double noise_of(std::vector<double> residuals) {
    if (residuals.empty())
        return 0;
    for (double &each : residuals)
        each = std::abs(each);
    const double outlier = 5 * 1.4826 * median(residuals);
    double sum = 0;
    std::size_t count = 0;
    for (const double each : residuals)
        if (each <= outlier) {
            sum += each * each;
            ++count;
        }
    return std::sqrt(sum / static_cast<double>(count));
}

double noise_of(const Eigen::VectorXd &x, const std::vector<ResidualBlock> &blocks) {
    std::vector<double> all;
    Eigen::VectorXd r;
    for (const ResidualBlock &block : blocks) {
        r.resize(block.count);
        block.evaluate(x, r);
        all.insert(all.end(), r.begin(), r.end());
    }
    return noise_of(std::move(all));
}

} // namespace afterglow
