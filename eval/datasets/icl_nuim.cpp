// SPDX-License-Identifier: Apache-2.0
#include "eval/datasets/icl_nuim.hpp"

#include "drivers/files/text_fields.hpp"
#include "eval/datasets/layout.hpp"

#include <Eigen/Geometry>

#include <algorithm>
#include <array>
#include <cmath>
#include <filesystem>
#include <map>
#include <optional>
#include <sstream>

namespace afterglow {
namespace {

namespace fs = std::filesystem;

constexpr double units_per_metre = 5000;

/// The poses of *.gt.freiburg, by frame number: camera to world with y up, turned y down here.
Result<std::map<std::int64_t, Pose>> read_poses(const std::string &folder) {
    std::map<std::int64_t, Pose> poses;
    const std::vector<std::string> files =
        files_in(folder, [](const std::string &name) { return name.ends_with(".gt.freiburg"); });
    if (files.empty())
        return poses;
    Result<TextFields> lines = TextFields::read(folder + "/" + files.front());
    if (!lines)
        return lines.error();
    while (lines->next_line()) {
        std::array<double, 8> x{};
        for (std::size_t i = 0; i < x.size(); ++i) {
            const std::optional<double> number =
                lines->size() == x.size() ? lines->number(i) : std::nullopt;
            if (!number)
                return lines->error("is not a pose: frame tx ty tz qx qy qz qw");
            x[i] = *number;
        }
        const Eigen::Quaterniond rotation(x[7], x[4], x[5], x[6]);
        if (x[0] < 0 || x[0] > double(max_frame_number) || std::abs(rotation.norm() - 1) > 0.01)
            return lines->error("has no frame number, or qx qy qz qw is not a unit quaternion");
        const Eigen::DiagonalMatrix<double, 3> flip(1, -1, 1);
        poses[std::llround(x[0])] = {flip * rotation.normalized().toRotationMatrix() * flip,
                                     flip * Eigen::Vector3d(x[1], x[2], x[3])};
    }
    return poses;
}

/// A file that a list names, which must be in `folder` beside the list.
bool is_in(const std::string &folder, const fs::path &file) {
    return file.begin() != file.end() && *file.begin() == folder &&
           std::find(file.begin(), file.end(), "..") == file.end();
}

/// The frame of a line of associations.txt, `0 depth/0.png 0 rgb/0.png`: depth comes first, and
/// frames are numbered. Nothing for a line of another kind.
std::optional<std::int64_t> frame_of(const std::array<std::string, 4> &line) {
    const std::optional<std::int64_t> frame = frame_number(line[0]);
    return line[2] == line[0] && is_in("depth", line[1]) && is_in("rgb", line[3]) ? frame
                                                                                  : std::nullopt;
}

bool fits(const std::string &folder) {
    if (exists(folder + "/camera.txt"))
        return false;
    std::istringstream line(first_line(folder + "/associations.txt"));
    std::array<std::string, 4> fields;
    for (std::string &field : fields)
        line >> field;
    return frame_of(fields).has_value();
}

Result<Dataset> open(const std::string &folder) {
    Result<TextFields> lines = TextFields::read(folder + "/associations.txt");
    if (!lines)
        return lines.error();
    const Result<std::map<std::int64_t, Pose>> poses = read_poses(folder);
    if (!poses)
        return poses.error();
    Recording recording;
    recording.camera = icl_nuim_camera;
    recording.depth_units_per_metre = units_per_metre;
    std::vector<std::optional<Pose>> pose_of_entry;
    while (lines->next_line()) {
        std::array<std::string, 4> line;
        for (std::size_t i = 0; i < line.size() && i < lines->size(); ++i)
            line[i] = (*lines)[i];
        const std::optional<std::int64_t> frame = frame_of(line);
        if (!frame || lines->size() != line.size())
            return lines->error("is not an association: frame depth/file frame rgb/file");
        const std::int64_t t_ns = icl_nuim_time_ns(*frame);
        recording.entries.push_back({t_ns, folder + "/" + line[3], t_ns, folder + "/" + line[1]});
        const auto pose = poses->find(*frame);
        pose_of_entry.push_back(pose != poses->end() ? std::optional(pose->second) : std::nullopt);
    }
    Dataset dataset = dataset_of(std::move(recording));
    for (std::size_t i = 0; i < dataset.frames.size(); ++i)
        dataset.frames[i].camera_to_world = pose_of_entry[i];
    return dataset;
}

} // namespace

const Layout icl_nuim_layout = {
    "icl-nuim", "associations.txt with lines such as `0 depth/0.png 0 rgb/0.png`", fits, open};

} // namespace afterglow
