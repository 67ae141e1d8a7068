// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "core/base/result.hpp"
#include "core/base/rig_calibration.hpp"
#include "tools/ctl/calibration/node.hpp"

#include <optional>
#include <string>
#include <vector>

namespace afterglow {

/// A camera as a file describes it.
struct FoundCamera {
    std::string name = {}; ///< in the file
    CameraModel model = {};
    /// Takes points of the file's reference frame, any, to this camera's; metres.
    std::optional<Pose> pose = {};
    bool range_along_ray = false;
    double clock_shift_s = 0; ///< what a time stamp lacks to the file's reference clock
    double readout_s = 0;
    int size_line = 0; ///< 0: the file does not tell the size
    int matrix_line = 0;
    int distortion_line = 0;
};

/// What a file has, in its order.
struct FoundCalibration {
    std::string path = {};
    std::string format = {}; ///< "OpenCV", "ROS", "Kalibr", "afterglow"
    std::vector<FoundCamera> cameras = {};
    /// Of a file that has not two cameras: what it says of two, as FoundCamera::pose does.
    std::optional<Pose> second_from_first = {};
};

/// What files do not say about themselves.
struct CalibrationHints {
    double metres_per_unit = 1; ///< OpenCV: of translations
    bool fisheye = false;       ///< OpenCV: four coefficients are those of its fisheye model
};

/// Reads a file of any format that is known, told by its content. Errors: `file:line: key: what is
/// wrong (what is expected)`.
Result<FoundCalibration> read_calibration(const std::string &path, const CalibrationHints &hints);
/// The same of a file's text; `path` stands in messages.
Result<FoundCalibration> parse_found_calibration(const std::string &text, const std::string &path,
                                                 const CalibrationHints &hints);

/// Whether the numbers of a camera can be those of one. The error is as above.
Status check_camera(const FoundCamera &camera, const std::string &path);

// The formats, each in a file of its name. Errors: as of wrong().
Result<FoundCalibration> read_opencv(const Node &root, const CalibrationHints &hints);
Result<FoundCalibration> read_ros(const Node &root);
Result<FoundCalibration> read_kalibr(const Node &root);
bool is_ros(const Node &root);
bool is_kalibr(const Node &root);

// What they share.

/// Sets the focal lengths and the principal point from a 3 x 3 matrix.
Status take_matrix(const Node &node, FoundCamera &camera);
/// Sets lens and coefficients. Errors: their count is not one of OpenCV's, or what the file says
/// does more than the lens's model can.
Status take_distortion(const Node &node, Lens lens, FoundCamera &camera);
/// Sets the size from one node with both numbers.
Status take_size(const Node &size, FoundCamera &camera);
/// The same from a node each, children of `parent`. Errors: one is missing, too.
Status take_size(const Node &parent, std::string_view width, std::string_view height,
                 FoundCamera &camera);
/// The child of this name. Errors: it is missing; `what` is expected.
Result<const Node *> required(const Node &parent, std::string_view name, std::string_view what);
/// The rotation that `node` has in these numbers, made exact. Errors: it is none.
Result<Eigen::Matrix3d> rotation_of(const Node &node, const Eigen::Matrix3d &R);

} // namespace afterglow
