// SPDX-License-Identifier: Apache-2.0
//
// What cv::FileStorage writes: one camera, two, or the pose between two. Names are each program's
// own; these are those of OpenCV's samples and applications, and what others make of them.
#include "tools/ctl/calibration/found_calibration.hpp"

#include <fmt/format.h>

#include <initializer_list>
#include <optional>
#include <string_view>
#include <vector>

namespace afterglow {
namespace {

const Node *find_any(const Node &root, std::initializer_list<std::string_view> names,
                     std::string_view suffix) {
    for (const std::string_view name : names)
        if (const Node *node = root.find(fmt::format("{}{}", name, suffix)))
            return node;
    return nullptr;
}

const Node *find_matrix(const Node &root, std::string_view suffix) {
    return find_any(root, {"camera_matrix", "intrinsic_matrix", "intrinsics", "K", "M"}, suffix);
}

const Node *find_distortion(const Node &root, std::string_view suffix) {
    return find_any(root, {"distortion_coefficients", "dist_coeffs", "distortion", "dist", "D"},
                    suffix);
}

Status take_size_of(const Node &root, std::string_view suffix, FoundCamera &camera) {
    for (const std::string_view of : {suffix, std::string_view()}) {
        if (const Node *size =
                find_any(root, {"image_size", "camera_resolution", "resolution", "size"}, of))
            return take_size(*size, camera);
        if (find_any(root, {"image_width"}, of) != nullptr)
            return take_size(root, fmt::format("image_width{}", of),
                             fmt::format("image_height{}", of), camera);
    }
    return ok();
}

Result<Lens> lens_of(const Node &root, bool fisheye) {
    const Node *flag = root.find({"fisheye_model", "fisheye"});
    if (flag != nullptr && flag->text != "true" && flag->text != "false") {
        const Result<double> value = number(*flag);
        if (!value)
            return value.error();
        fisheye = fisheye || *value != 0;
    } else if (flag != nullptr) {
        fisheye = fisheye || flag->text == "true";
    }
    return fisheye ? Lens::kannala_brandt : Lens::brown_conrady;
}

Result<FoundCamera> read_camera(const Node &root, const Node &matrix, std::string_view suffix,
                                const CalibrationHints &hints) {
    FoundCamera camera{.name = matrix.name};
    if (const Status taken = take_matrix(matrix, camera); !taken)
        return taken.error();
    if (const Status taken = take_size_of(root, suffix, camera); !taken)
        return taken.error();
    const Result<Lens> lens = lens_of(root, hints.fisheye);
    if (!lens)
        return lens.error();
    const Node *distortion = find_distortion(root, suffix);
    if (distortion == nullptr)
        return wrong(matrix, "its distortion coefficients are missing (zeros for a pinhole)");
    if (const Status taken = take_distortion(*distortion, *lens, camera); !taken)
        return taken.error();
    return camera;
}

Result<std::optional<Pose>> read_pose(const Node &root, const CalibrationHints &hints) {
    const Node *R = root.find({"R", "rotation", "rotation_matrix"});
    const Node *T = root.find({"T", "translation", "translation_vector"});
    if (R == nullptr && T == nullptr)
        return std::optional<Pose>();
    if (R == nullptr || T == nullptr)
        return wrong(R != nullptr ? *R : *T, "stands alone (expected both R and T)");
    const Result<std::vector<double>> r = numbers(*R, {3, 9});
    if (!r)
        return r.error();
    Eigen::Matrix3d matrix;
    if (r->size() == 3)
        matrix = rotation(Eigen::Vector3d(r->data()));
    else
        matrix = Eigen::Matrix<double, 3, 3, Eigen::RowMajor>(r->data());
    const Result<Eigen::Matrix3d> exact = rotation_of(*R, matrix);
    if (!exact)
        return exact.error();
    const Result<std::vector<double>> t = numbers(*T, {3});
    if (!t)
        return t.error();
    return std::optional(Pose{*exact, Eigen::Vector3d(t->data()) * hints.metres_per_unit});
}

} // namespace

Result<FoundCalibration> read_opencv(const Node &root, const CalibrationHints &hints) {
    FoundCalibration found{.format = "OpenCV"};
    for (const std::string_view suffix : {"", "0", "1", "2", "left", "right", "l", "r"}) {
        const Node *matrix = find_matrix(root, suffix);
        if (matrix == nullptr)
            continue;
        const Result<FoundCamera> camera = read_camera(root, *matrix, suffix, hints);
        if (!camera)
            return camera.error();
        found.cameras.push_back(*camera);
    }
    const Result<std::optional<Pose>> pose = read_pose(root, hints);
    if (!pose)
        return pose.error();
    if (found.cameras.size() == 2 && *pose) {
        found.cameras.front().pose = Pose::identity();
        found.cameras.back().pose = *pose;
    } else {
        found.second_from_first = *pose;
    }
    if (found.cameras.empty() && !*pose)
        return wrong(root, "this is no calibration that is known (expected a camera_matrix of "
                           "OpenCV or ROS, cameras of Kalibr, or R and T)");
    return found;
}

} // namespace afterglow
