// SPDX-License-Identifier: Apache-2.0
//
// A camera chain of Kalibr: cam0, cam1 and so on, each with its place relative to the one before,
// or to an IMU.
#include "core/base/printable.hpp"
#include "tools/ctl/calibration/found_calibration.hpp"

#include <fmt/format.h>

#include <algorithm>

namespace afterglow {
namespace {

Result<Lens> lens_of(const Node &camera) {
    const Result<const Node *> model =
        required(camera, "distortion_model", "radtan, equidistant or none");
    if (!model)
        return model.error();
    if ((*model)->text == "radtan")
        return Lens::brown_conrady;
    if ((*model)->text == "equidistant" || (*model)->text == "equi")
        return Lens::kannala_brandt;
    if ((*model)->text == "none")
        return Lens::pinhole;
    return wrong(**model, fmt::format("\"{}\" is not known here (radtan, equidistant or none)",
                                      printable((*model)->text)));
}

Result<Pose> pose_of(const Node &node) {
    const Result<std::vector<double>> m = numbers(node, {16});
    if (!m)
        return m.error();
    const Eigen::Matrix4d T = Eigen::Matrix<double, 4, 4, Eigen::RowMajor>(m->data());
    if (T.row(3) != Eigen::RowVector4d(0, 0, 0, 1))
        return wrong(node, "is not a rigid motion (expected a last row of 0, 0, 0, 1)");
    const Result<Eigen::Matrix3d> R = rotation_of(node, T.topLeftCorner<3, 3>());
    if (!R)
        return R.error();
    return Pose{*R, T.topRightCorner<3, 1>()};
}

Status take_intrinsics(const Node &node, FoundCamera &camera) {
    const Result<const Node *> model = required(node, "camera_model", "pinhole");
    if (!model)
        return model.error();
    if ((*model)->text != "pinhole")
        return wrong(**model,
                     fmt::format("\"{}\" is not known here (pinhole)", printable((*model)->text)));
    const Result<const Node *> intrinsics = required(node, "intrinsics", "fu, fv, pu, pv");
    if (!intrinsics)
        return intrinsics.error();
    const Result<std::vector<double>> values = numbers(**intrinsics, {4});
    if (!values)
        return values.error();
    Intrinsics &pinhole = camera.model.pinhole;
    pinhole.fx = (*values)[0];
    pinhole.fy = (*values)[1];
    pinhole.cx = (*values)[2];
    pinhole.cy = (*values)[3];
    camera.matrix_line = (*intrinsics)->line;
    const Result<const Node *> size = required(node, "resolution", "width and height");
    return size ? take_size(**size, camera) : size.error();
}

Status take_lens(const Node &node, FoundCamera &camera) {
    const Result<Lens> lens = lens_of(node);
    if (!lens)
        return lens.error();
    if (*lens == Lens::pinhole)
        return ok();
    const Result<const Node *> distortion = required(node, "distortion_coeffs", "4 numbers");
    return distortion ? take_distortion(**distortion, *lens, camera) : distortion.error();
}

/// `before`: the camera before this one in the chain, if there is one.
Status take_pose(const Node &node, const FoundCamera *before, FoundCamera &camera) {
    const Node *from_before = node.find("T_cn_cnm1");
    const Node *from_imu = node.find("T_cam_imu");
    if (const Node *shift = node.find("timeshift_cam_imu")) {
        const Result<double> seconds = number(*shift);
        if (!seconds)
            return seconds.error();
        camera.clock_shift_s = *seconds;
    }
    if (from_before == nullptr && from_imu == nullptr) {
        if (before == nullptr)
            camera.pose = Pose::identity();
        return ok();
    }
    const bool chained = from_before != nullptr && before != nullptr;
    if (!chained && from_imu == nullptr)
        return wrong(*from_before, "there is no camera before this one");
    const Result<Pose> pose = pose_of(chained ? *from_before : *from_imu);
    if (!pose)
        return pose.error();
    if (!chained)
        camera.pose = *pose;
    else if (before->pose)
        camera.pose = *pose * *before->pose;
    return ok();
}

} // namespace

bool is_kalibr(const Node &root) {
    return std::any_of(root.children.begin(), root.children.end(),
                       [](const Node &camera) { return camera.find("camera_model") != nullptr; });
}

Result<FoundCalibration> read_kalibr(const Node &root) {
    FoundCalibration chain{.format = "Kalibr"};
    for (const Node &node : root.children) {
        if (!node.name.starts_with("cam"))
            continue;
        FoundCamera camera{.name = node.name};
        const FoundCamera *before = chain.cameras.empty() ? nullptr : &chain.cameras.back();
        for (const Status &taken : {take_intrinsics(node, camera), take_lens(node, camera),
                                    take_pose(node, before, camera)})
            if (!taken)
                return taken.error();
        chain.cameras.push_back(camera);
    }
    return chain;
}

} // namespace afterglow
