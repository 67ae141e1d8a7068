// SPDX-License-Identifier: Apache-2.0
#include "tools/ctl/calibration/found_calibration.hpp"

#include "config/calibration_file.hpp"
#include "config/calibration_limits.hpp"
#include "core/base/printable.hpp"
#include "core/base/read_file.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cerrno>
#include <cmath>

namespace afterglow {
namespace {

constexpr std::size_t largest_file = 1 << 20;

/// The first line that is not empty and not a comment.
std::string_view first_line(std::string_view text) {
    while (!text.empty()) {
        const std::size_t end = std::min(text.find('\n'), text.size());
        const std::string_view line = text.substr(0, end);
        text.remove_prefix(std::min(end + 1, text.size()));
        const std::size_t begin = line.find_first_not_of(" \t\r");
        if (begin < line.size() && line[begin] != '#')
            return line.substr(begin);
    }
    return {};
}

/// Of a file of our own. What YAML has in braces would be a list there, not a map.
bool is_toml(std::string_view line) {
    return !line.starts_with('<') && (line.starts_with('[') || line.find('=') < line.find(':'));
}

FoundCalibration found(const RigCalibration &rig) {
    FoundCalibration found;
    found.format = "afterglow";
    FoundCamera color{.name = "color", .model = rig.color, .pose = Pose::identity()};
    color.readout_s = rig.readout_s;
    FoundCamera tof{.name = "tof", .model = rig.tof, .pose = rig.tof_from_color};
    tof.range_along_ray = rig.range_along_ray;
    tof.clock_shift_s = rig.tof_delay_s;
    color.size_line = tof.size_line = 1; // it has been checked, with the lines
    found.cameras = {color, tof};
    return found;
}

Result<FoundCalibration> read_tree(const Node &root, const CalibrationHints &hints) {
    if (is_kalibr(root))
        return read_kalibr(root);
    if (is_ros(root))
        return read_ros(root);
    return read_opencv(root, hints);
}

/// `width_node`, `height_node`: where the numbers stand.
Status set_size(const Node &width_node, double width, const Node &height_node, double height,
                FoundCamera &camera) {
    Intrinsics &pinhole = camera.model.pinhole;
    for (const auto &[node, value, size] : {std::tuple(&width_node, width, &pinhole.width),
                                            {&height_node, height, &pinhole.height}}) {
        if (!(value >= 0 && value <= 1e6) || value != std::floor(value))
            return wrong(*node, fmt::format("{:g} is not a number of pixels", value));
        *size = static_cast<int>(value);
    }
    camera.size_line = width_node.line;
    return ok();
}

} // namespace

Result<FoundCalibration> parse_found_calibration(const std::string &text, const std::string &path,
                                                 const CalibrationHints &hints) {
    if (text.size() > largest_file)
        return Error{
            fmt::format("{}: is too large for a calibration (at most 1 MiB)", printable(path)),
            EFBIG};
    const std::string_view line = first_line(text);
    if (is_toml(line)) {
        const Result<RigCalibration> rig = parse_calibration(text, path);
        if (!rig)
            return rig.error();
        FoundCalibration calibration = found(*rig);
        calibration.path = path;
        return calibration;
    }
    const Result<Node> root = line.starts_with('<') ? parse_xml(text) : parse_yaml(text);
    Result<FoundCalibration> calibration = root ? read_tree(*root, hints) : root.error();
    if (!calibration)
        return Error{fmt::format("{}:{}", printable(path), calibration.error().message),
                     calibration.error().code};
    calibration->path = path;
    for (const FoundCamera &camera : calibration->cameras)
        if (camera.size_line != 0)
            if (const Status checked = check_camera(camera, path); !checked)
                return checked.error();
    return calibration;
}

Result<FoundCalibration> read_calibration(const std::string &path, const CalibrationHints &hints) {
    const Result<std::string> text = read_file(path, largest_file);
    return text ? parse_found_calibration(*text, path, hints) : text.error();
}

Status check_camera(const FoundCamera &camera, const std::string &path) {
    const auto problem = problem_of(camera.model);
    if (!problem)
        return ok();
    int line = camera.matrix_line;
    if (problem->key == "width" || problem->key == "height")
        line = camera.size_line;
    else if (problem->key == "distortion")
        line = camera.distortion_line;
    return Error{
        fmt::format("{}:{}: {}: {}", printable(path), line, problem->key, problem->sentence),
        EINVAL};
}

Status take_matrix(const Node &node, FoundCamera &camera) {
    const Result<std::vector<double>> m = numbers(node, {9});
    if (!m)
        return m.error();
    const double one = (*m)[8];
    if (one != 1 || (*m)[3] != 0 || (*m)[6] != 0 || (*m)[7] != 0)
        return wrong(node, "is not a camera matrix (expected fx 0 cx, 0 fy cy, 0 0 1)");
    if ((*m)[1] != 0)
        return wrong(node, "has skew (expected a 0 in the second column of the first row)");
    Intrinsics &pinhole = camera.model.pinhole;
    pinhole.fx = (*m)[0];
    pinhole.cx = (*m)[2];
    pinhole.fy = (*m)[4];
    pinhole.cy = (*m)[5];
    camera.matrix_line = node.line;
    return ok();
}

Status take_distortion(const Node &node, Lens lens, FoundCamera &camera) {
    const Result<std::vector<double>> k =
        lens == Lens::kannala_brandt ? numbers(node, {4}) : numbers(node, {0, 4, 5, 8, 12, 14});
    if (!k)
        return k.error();
    // The eighth is the last; what OpenCV has beyond is a tilted sensor or a thin prism.
    auto &known = camera.model.distortion;
    const std::size_t taken = std::min(k->size(), known.size());
    const auto end = k->begin() + static_cast<std::ptrdiff_t>(taken);
    if (std::any_of(end, k->end(), [](double further) { return further != 0; }))
        return wrong(node, "has a thin prism or a tilted sensor (expected 4, 5 or 8 coefficients)");
    std::copy(k->begin(), end, known.begin());
    const bool bends = std::any_of(k->begin(), k->end(), [](double each) { return each != 0; });
    // Of the fisheye model, zeros are a lens, too.
    camera.model.lens = bends || lens == Lens::kannala_brandt ? lens : Lens::pinhole;
    camera.distortion_line = node.line;
    return ok();
}

Status take_size(const Node &size, FoundCamera &camera) {
    const Result<std::vector<double>> values = numbers(size, {2});
    if (!values)
        return values.error();
    return set_size(size, values->front(), size, values->back(), camera);
}

Status take_size(const Node &parent, std::string_view width, std::string_view height,
                 FoundCamera &camera) {
    double values[2];
    for (const auto &[name, value] : {std::pair(width, &values[0]), {height, &values[1]}}) {
        const Result<const Node *> node = required(parent, name, "a number of pixels");
        if (!node)
            return node.error();
        const Result<double> pixels = number(**node);
        if (!pixels)
            return pixels.error();
        *value = *pixels;
    }
    return set_size(*parent.find(width), values[0], *parent.find(height), values[1], camera);
}

Result<const Node *> required(const Node &parent, std::string_view name, std::string_view what) {
    const Node *node = parent.find(name);
    if (node == nullptr)
        return wrong(parent, fmt::format("{} is missing ({})", name, what));
    return node;
}

Result<Eigen::Matrix3d> rotation_of(const Node &node, const Eigen::Matrix3d &R) {
    const auto exact = exact_rotation(R);
    return exact ? Result<Eigen::Matrix3d>(*exact)
                 : wrong(node, "is not a rotation (orthonormal rows to 1e-3, and no mirror)");
}

} // namespace afterglow
