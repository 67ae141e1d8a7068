// SPDX-License-Identifier: Apache-2.0
#include "eval/datasets/dataset.hpp"

#include "drivers/files/image_file.hpp"
#include "drivers/files/recording.hpp"
#include "eval/datasets/layout.hpp"

#include <fmt/format.h>
#include <system_error>

#include <algorithm>
#include <array>
#include <cerrno>
#include <charconv>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <memory>

namespace afterglow {
namespace {

namespace fs = std::filesystem;

/// The surer the signs, the earlier.
const std::array layouts = {&tum_layout,          &icl_nuim_layout,     &icl_nuim_povray_layout,
                            &corbs_layout,        &tum_original_layout, &nyu_v2_layout,
                            &seven_scenes_layout, &open3d_layout,       &indoor_rgbd_layout};

Error unrecognised(const std::string &folder) {
    std::string message = fmt::format("{}: is not in a layout that is known; looked for", folder);
    for (const Layout *layout : layouts)
        message += fmt::format("{} {} ({})", layout == layouts.front() ? "" : ",", layout->signs,
                               layout->name);
    return {message, EINVAL};
}

} // namespace

std::int64_t Dataset::Frame::depth_time_ns() const {
    const bool near = t_depth_ns >= 0 && std::abs(t_depth_ns - t_ns) <= recording_tolerance_ns;
    return near ? t_depth_ns : t_ns;
}

std::vector<std::string_view> dataset_layouts() {
    std::vector<std::string_view> names;
    for (const Layout *layout : layouts)
        names.emplace_back(layout->name);
    return names;
}

Result<Dataset> open_dataset(const std::string &folder, std::string_view layout_name) {
    std::error_code problem;
    if (!fs::is_directory(folder, problem))
        return Error{fmt::format("{}: is not a folder", folder), ENOTDIR};
    const auto layout = std::find_if(layouts.begin(), layouts.end(), [&](const Layout *candidate) {
        return layout_name.empty() ? candidate->fits(folder) : candidate->name == layout_name;
    });
    if (layout == layouts.end() && !layout_name.empty())
        return Error{fmt::format("there is no layout \"{}\"; there are {}", layout_name,
                                 fmt::join(dataset_layouts(), ", ")),
                     EINVAL};
    if (layout == layouts.end())
        return unrecognised(folder);

    Result<Dataset> dataset = (*layout)->open(folder);
    if (!dataset)
        return dataset;
    dataset->layout = (*layout)->name;
    // A time that is not later than the one before is a frame out of order.
    std::vector<Dataset::Frame> in_order;
    for (Dataset::Frame &frame : dataset->frames) {
        if (in_order.empty() || frame.t_ns > in_order.back().t_ns)
            in_order.push_back(std::move(frame));
        else
            skip(*dataset, frame.color_path + ": its time is not later than the one before");
    }
    dataset->frames = std::move(in_order);
    if (dataset->frames.empty())
        return Error{fmt::format("{}: has no frames ({}){}{}", folder, (*layout)->name,
                                 dataset->skipped > 0 ? ": " : "", dataset->skipped_reason),
                     EINVAL};
    return dataset;
}

Error not_registered(const std::string &folder, const std::string &calibration) {
    return {fmt::format("{}: is a recording of two cameras ({}), and depth that is registered to "
                        "the images is needed",
                        folder, calibration),
            EINVAL};
}

Dataset dataset_of(Recording recording) {
    Dataset dataset;
    dataset.camera = recording.camera;
    dataset.skipped = recording.skipped;
    dataset.skipped_reason = std::move(recording.skipped_reason);
    for (Recording::Entry &entry : recording.entries)
        dataset.frames.push_back({entry.t_color_ns, entry.t_depth_ns, std::move(entry.color_path),
                                  std::move(entry.depth_path),
                                  recording.ground_truth.camera_to_world(entry.t_color_ns)});
    dataset.read_luma = [camera = recording.camera](const std::string &path) {
        return read_luma_sized(path, camera);
    };
    dataset.read_depth = [camera = recording.camera,
                          units = recording.depth_units_per_metre](const std::string &path) {
        return read_depth_png(path, camera, units);
    };
    return dataset;
}

Dataset dataset_of(Recording recording, const NumberedFiles &colors, const NumberedFiles &depths,
                   std::int64_t per_second) {
    for (const auto &[number, color] : colors) {
        const std::int64_t t_ns = number * 1'000'000'000 / per_second;
        if (const auto depth = depths.find(number); depth != depths.end())
            recording.entries.push_back({t_ns, color, t_ns, depth->second});
    }
    Dataset dataset = dataset_of(std::move(recording));
    for (const auto &[number, color] : colors)
        if (!depths.contains(number))
            skip(dataset, color + ": has no depth map of its number");
    for (const auto &[number, depth] : depths)
        if (!colors.contains(number))
            skip(dataset, depth + ": has no image of its number");
    return dataset;
}

Result<Luma> read_luma_sized(const std::string &path, const Intrinsics &camera) {
    Luma luma(camera.width, camera.height);
    if (Status read = read_luma(path, luma.view()); !read)
        return read.error();
    return luma;
}

Result<DepthMap> read_depth_png(const std::string &path, const Intrinsics &camera,
                                double units_per_metre) {
    Recording recording;
    recording.camera = camera;
    recording.depth_units_per_metre = units_per_metre;
    recording.entries.push_back({0, "", 0, path});
    DepthMap depth(camera.width, camera.height);
    if (Status read = read_depth_mm(recording, 0, depth.view()); !read)
        return read.error();
    return depth;
}

bool exists(const std::string &path) {
    std::error_code problem;
    return fs::exists(path, problem);
}

std::string folder_name(const std::string &folder) {
    const fs::path path = fs::absolute(folder).lexically_normal();
    return (path.has_filename() ? path : path.parent_path()).filename().string();
}

std::string first_line(const std::string &path) {
    std::ifstream file(path);
    std::string line;
    while (std::getline(file, line) && (line.empty() || line.front() == '#'))
        line.clear();
    return line;
}

std::vector<std::string> files_in(const std::string &folder,
                                  const std::function<bool(const std::string &name)> &wanted) {
    std::vector<std::string> names;
    std::error_code problem;
    for (fs::directory_iterator file(folder, problem), end; !problem && file != end;
         file.increment(problem)) {
        if (std::string name = file->path().filename().string(); wanted(name))
            names.push_back(std::move(name));
    }
    std::sort(names.begin(), names.end());
    return names;
}

std::optional<std::int64_t> frame_number(std::string_view digits) {
    const char *const end = digits.data() + digits.size();
    std::int64_t number = 0;
    const auto [stop, problem] = std::from_chars(digits.data(), end, number);
    if (problem != std::errc() || stop != end || number < 0 || number > max_frame_number)
        return std::nullopt;
    return number;
}

void skip(Dataset &dataset, std::string reason) {
    if (dataset.skipped++ == 0)
        dataset.skipped_reason = std::move(reason);
}

} // namespace afterglow
