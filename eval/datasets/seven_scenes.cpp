// SPDX-License-Identifier: Apache-2.0
#include "drivers/files/image_file.hpp"
#include "drivers/files/text_fields.hpp"
#include "eval/datasets/layout.hpp"
#include "eval/datasets/registration.hpp"

#include <Eigen/LU>
#include <fmt/format.h>

#include <cerrno>
#include <memory>

namespace afterglow {
namespace {

// The dataset's page gives the depth camera; its colour camera was never published. Those who
// register the two take a Kinect's nominal one, and where another Kinect was measured to have it
// (the calibration of LIRIS, Lyon, also in the ACE relocaliser's set-up of this dataset).
constexpr Intrinsics depth = {585, 585, 320, 240, 640, 480};
constexpr Intrinsics color = {525, 525, 320, 240, 640, 480};
constexpr std::uint16_t nothing = 65535;
constexpr std::int64_t frames_per_second = 30;

Pose depth_to_color() {
    Pose pose;
    pose.R << 9.9996518012567637e-01, 2.6765126468950343e-03, -7.9041012313000904e-03,
        -2.7409311281316700e-03, 9.9996302803027592e-01, -8.1504520778013286e-03,
        7.8819942130445332e-03, 8.1718328771890631e-03, 9.9993554558014031e-01;
    pose.T = {-2.5558943178152542e-02, 1.0109636268061706e-04, 2.0318321729487039e-03};
    return pose;
}

/// The number of frame-000000.color.png.
std::optional<std::int64_t> frame_of(const std::string &name) {
    constexpr std::string_view before = "frame-", after = ".color.png";
    if (name.size() <= before.size() + after.size() || !name.starts_with(before) ||
        !name.ends_with(after))
        return std::nullopt;
    return frame_number(
        std::string_view(name).substr(before.size(), name.size() - before.size() - after.size()));
}

bool is_color(const std::string &name) {
    return frame_of(name).has_value();
}

/// A 4 x 4 matrix, depth camera to world, as the colour camera's pose. Where tracking was lost the
/// files hold no rigid motion: then nothing is known.
Result<std::optional<Pose>> read_pose(const std::string &path) {
    if (!exists(path))
        return std::optional<Pose>();
    Result<TextFields> lines = TextFields::read(path);
    if (!lines)
        return lines.error();
    Eigen::Matrix4d matrix = Eigen::Matrix4d::Zero();
    for (int row = 0; row < 4; ++row) {
        if (!lines->next_line() || lines->size() != 4)
            return Error{fmt::format("{}: is not a matrix of 4 x 4 numbers", path), EINVAL};
        for (int column = 0; column < 4; ++column)
            matrix(row, column) = lines->number(static_cast<std::size_t>(column)).value_or(0);
    }
    const Pose pose{matrix.topLeftCorner<3, 3>(), matrix.topRightCorner<3, 1>()};
    const bool rigid = (pose.R * pose.R.transpose() - Eigen::Matrix3d::Identity()).norm() < 0.01 &&
                       pose.R.determinant() > 0;
    return rigid ? std::optional(pose * depth_to_color().inverse()) : std::nullopt;
}

Result<DepthMap> read_depth(const std::string &path, const DepthRegistration &registration) {
    Image<std::uint16_t> mm(depth.width, depth.height);
    if (Status read = read_grey16(path, mm.view()); !read)
        return read.error();
    Image<float> metres(depth.width, depth.height);
    for (std::size_t i = 0; i < mm.pixels().size(); ++i) {
        if (const std::uint16_t value = mm.pixels()[i]; value != nothing)
            metres.pixels()[i] = static_cast<float>(value) / 1000;
    }
    return registration.registered(metres.view());
}

bool fits(const std::string &folder) {
    return !files_in(folder, is_color).empty();
}

Result<Dataset> open(const std::string &folder) {
    Dataset dataset;
    dataset.camera = color;
    for (const std::string &name : files_in(folder, is_color)) {
        const std::int64_t frame = *frame_of(name);
        const std::string stem = folder + "/" + name.substr(0, name.find('.'));
        if (!exists(stem + ".depth.png")) {
            skip(dataset, stem + ".depth.png: is missing");
            continue;
        }
        const Result<std::optional<Pose>> pose = read_pose(stem + ".pose.txt");
        if (!pose)
            return pose.error();
        const std::int64_t t_ns = frame * 1'000'000'000 / frames_per_second;
        dataset.frames.push_back({t_ns, t_ns, folder + "/" + name, stem + ".depth.png", *pose});
    }
    dataset.read_luma = [](const std::string &path) { return read_luma_sized(path, color); };
    dataset.read_depth = [registration = std::make_shared<const DepthRegistration>(
                              depth, LensDistortion{}, depth_to_color(), color)](
                             const std::string &path) { return read_depth(path, *registration); };
    dataset.assumed = "the dataset does not say where its colour camera is nor how it sees: the "
                      "calibration of another Kinect was assumed";
    return dataset;
}

} // namespace

const Layout seven_scenes_layout = {"7-scenes", "frame-000000.color.png and .depth.png", fits,
                                    open};

} // namespace afterglow
