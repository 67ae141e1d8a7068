// SPDX-License-Identifier: Apache-2.0
//
// What camera_calibration of ROS writes and camera_info_manager reads: one camera.
#include "core/base/printable.hpp"
#include "tools/ctl/calibration/found_calibration.hpp"

#include <fmt/format.h>

namespace afterglow {
namespace {

Result<Lens> lens_by_name(const Node &model) {
    if (model.text == "plumb_bob" || model.text == "rational_polynomial")
        return Lens::brown_conrady;
    if (model.text == "equidistant" || model.text == "fisheye")
        return Lens::kannala_brandt;
    return wrong(model, fmt::format("\"{}\" is not known here (plumb_bob, rational_polynomial or "
                                    "equidistant)",
                                    printable(model.text)));
}

} // namespace

bool is_ros(const Node &root) {
    return root.find("distortion_model") != nullptr;
}

Result<FoundCalibration> read_ros(const Node &root) {
    FoundCamera camera;
    if (const Node *name = root.find("camera_name"))
        camera.name = name->text;
    if (const Status size = take_size(root, "image_width", "image_height", camera); !size)
        return size.error();
    const Result<const Node *> matrix = required(root, "camera_matrix", "9 numbers");
    if (!matrix)
        return matrix.error();
    if (const Status taken = take_matrix(**matrix, camera); !taken)
        return taken.error();
    const Result<Lens> lens = lens_by_name(*root.find("distortion_model"));
    if (!lens)
        return lens.error();
    const Result<const Node *> distortion =
        required(root, "distortion_coefficients", "4, 5 or 8 numbers");
    if (!distortion)
        return distortion.error();
    if (const Status taken = take_distortion(**distortion, *lens, camera); !taken)
        return taken.error();
    return FoundCalibration{.format = "ROS", .cameras = {camera}};
}

} // namespace afterglow
