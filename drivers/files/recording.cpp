// SPDX-License-Identifier: Apache-2.0
#include "drivers/files/recording.hpp"

#include "core/base/printable.hpp"
#include "drivers/files/image_file.hpp"
#include "drivers/files/text_fields.hpp"

#include <fmt/format.h>
#include <system_error>

#include <algorithm>
#include <cassert>
#include <cerrno>
#include <cstdlib>
#include <filesystem>
#include <string_view>

namespace afterglow {
namespace {

namespace fs = std::filesystem;

/// A line of rgb.txt or depth.txt.
struct Stamped {
    std::int64_t t_ns;
    std::string path;
    Error not_paired; ///< what to say if it is left out
};

void skip(Recording &recording, const Error &why) {
    if (recording.skipped++ == 0)
        recording.skipped_reason = why.message;
}

/// A file named by a recording, which may only name what is in its own folder. Lists written on
/// Windows (the CoRBS benchmark's) name rgb\1.png.
Result<std::string> path_inside(const std::string &folder, const TextFields &line,
                                std::size_t field) {
    std::string name = line[field];
    std::replace(name.begin(), name.end(), '\\', '/');
    const fs::path path = name;
    if (path.is_absolute() || std::find(path.begin(), path.end(), "..") != path.end())
        return line.error(
            fmt::format("{} is outside the recording's folder", printable(line[field])));
    return (fs::path(folder) / path).string();
}

/// Takes an entry whose time has been checked against its neighbour's depth, if it comes in order.
void append(Recording &recording, Recording::Entry entry, const TextFields &line) {
    const std::int64_t tolerance_ns = recording.rig ? rig_tolerance_ns : recording_tolerance_ns;
    if (std::abs(entry.t_depth_ns - entry.t_color_ns) > tolerance_ns)
        skip(recording, line.error(fmt::format("the depth map is more than {} ms from the image",
                                               tolerance_ns / 1'000'000)));
    else if (!recording.entries.empty() && entry.t_color_ns <= recording.entries.back().t_color_ns)
        skip(recording, line.error("the time is not later than the one before"));
    else
        recording.entries.push_back(std::move(entry));
}

Status read_associations(const std::string &path, Recording &recording) {
    Result<TextFields> lines = TextFields::read(path);
    if (!lines)
        return lines.error();
    while (lines->next_line()) {
        const TextFields &line = *lines;
        if (line.size() != 4 || !line.time_ns(0) || !line.time_ns(2))
            return line.error("is not an association: time color_file time depth_file");
        const Result<std::string> color = path_inside(recording.folder, line, 1);
        const Result<std::string> depth = path_inside(recording.folder, line, 3);
        if (!color || !depth)
            return color ? depth.error() : color.error();
        append(recording, {*line.time_ns(0), *color, *line.time_ns(2), *depth}, line);
    }
    return ok();
}

/// Lines by rising time; the others are skipped.
Result<std::vector<Stamped>> read_list(const std::string &path, Recording &recording) {
    Result<TextFields> lines = TextFields::read(path);
    if (!lines)
        return lines.error();
    std::vector<Stamped> list;
    while (lines->next_line()) {
        const std::optional<std::int64_t> t_ns = lines->time_ns(0);
        if (lines->size() != 2 || !t_ns)
            return lines->error("is not a frame: time file");
        const Result<std::string> file = path_inside(recording.folder, *lines, 1);
        if (!file)
            return file.error();
        if (!list.empty() && *t_ns <= list.back().t_ns)
            skip(recording, lines->error("the time is not later than the one before"));
        else
            list.push_back({*t_ns, *file, lines->error("the image has no depth map within 20 ms")});
    }
    return list;
}

/// The index of the frame of a list, not empty, that is nearest in time.
std::size_t nearest(const std::vector<Stamped> &list, std::int64_t t_ns) {
    const auto after =
        std::lower_bound(list.begin(), list.end(), t_ns,
                         [](const Stamped &f, std::int64_t t) { return f.t_ns < t; });
    if (after == list.begin())
        return 0;
    const auto before = after - 1;
    const bool later = after != list.end() && after->t_ns - t_ns < t_ns - before->t_ns;
    return static_cast<std::size_t>((later ? after : before) - list.begin());
}

Status read_and_pair(const std::string &folder, Recording &recording) {
    const Result<std::vector<Stamped>> colors = read_list(folder + "/rgb.txt", recording);
    if (!colors)
        return colors.error();
    const Result<std::vector<Stamped>> depths = read_list(folder + "/depth.txt", recording);
    if (!depths)
        return depths.error();
    for (std::size_t i = 0; i < colors->size(); ++i) {
        const Stamped &color = (*colors)[i];
        const std::size_t j = depths->empty() ? 0 : nearest(*depths, color.t_ns);
        if (depths->empty() || nearest(*colors, (*depths)[j].t_ns) != i ||
            std::abs((*depths)[j].t_ns - color.t_ns) > recording_tolerance_ns)
            skip(recording, color.not_paired);
        else
            recording.entries.push_back(
                {color.t_ns, color.path, (*depths)[j].t_ns, (*depths)[j].path});
    }
    return ok();
}

bool exists(const std::string &path) {
    std::error_code problem;
    return fs::exists(path, problem);
}

/// Which files would have to be there to make a folder a recording.
Status check_files(const std::string &folder, bool needs_camera) {
    if (std::error_code problem; !fs::is_directory(folder, problem))
        return Error{fmt::format("{}: is not a folder", folder), ENOTDIR};
    std::string missing;
    if (needs_camera && !exists(folder + "/camera.txt"))
        missing = "camera.txt";
    if (!exists(folder + "/associations.txt") &&
        !(exists(folder + "/rgb.txt") && exists(folder + "/depth.txt")))
        missing += fmt::format("{}associations.txt (or rgb.txt and depth.txt)",
                               missing.empty() ? "" : " and ");
    if (!missing.empty())
        return Error{fmt::format("{}: is not a recording: {} missing", folder, missing), ENOENT};
    return ok();
}

} // namespace

std::string camera_problem(const std::array<double, 6> &camera) {
    const auto [fx, fy, cx, cy, width, height] = camera;
    const auto is_side = [](double side) {
        return side >= 1 && side <= max_image_side && side == static_cast<int>(side);
    };
    if (!is_side(width) || !is_side(height))
        return fmt::format("width and height are whole numbers from 1 to {}, not {} and {}",
                           max_image_side, width, height);
    if (!(fx >= 1 && fx <= 1e5 && fy >= 1 && fy <= 1e5))
        return "fx and fy are numbers of pixels from 1 to 100000";
    if (!(cx >= 0 && cx <= width && cy >= 0 && cy <= height))
        return fmt::format("the centre ({}, {}) is outside the image", cx, cy);
    return {};
}

Result<RecordingCamera> read_recording_camera(const std::string &folder) {
    Result<TextFields> lines = TextFields::read(folder + "/camera.txt");
    if (!lines)
        return lines.error();
    constexpr std::string_view expected =
        "fx fy cx cy width height depth_units_per_metre are expected";
    if (!lines->next_line())
        return Error{fmt::format("{}/camera.txt: is empty: {}", folder, expected), EINVAL};
    std::array<double, 7> x{};
    if (lines->size() != x.size())
        return lines->error(fmt::format("has {} fields: {}", lines->size(), expected));
    for (std::size_t i = 0; i < x.size(); ++i) {
        const std::optional<double> number = lines->number(i);
        if (!number)
            return lines->error(fmt::format("{} is not a number: {}", (*lines)[i], expected));
        x[i] = *number;
    }
    if (const std::string problem = camera_problem({x[0], x[1], x[2], x[3], x[4], x[5]});
        !problem.empty())
        return lines->error(problem);
    if (x[6] <= 0)
        return lines->error("depth_units_per_metre is a positive number");
    if (lines->next_line())
        return lines->error("nothing is expected after the camera's line");
    return RecordingCamera{{x[0], x[1], x[2], x[3], static_cast<int>(x[4]), static_cast<int>(x[5])},
                           x[6]};
}

Result<Recording> open_recording(const std::string &folder,
                                 const std::optional<RecordingCamera> &camera,
                                 const std::optional<RigCalibration> &rig) {
    if (Status there = check_files(folder, !camera); !there)
        return there.error();
    const Result<RecordingCamera> taken_with =
        camera && !exists(folder + "/camera.txt") ? *camera : read_recording_camera(folder);
    if (!taken_with)
        return taken_with.error();
    Recording recording;
    recording.folder = folder;
    recording.camera = taken_with->intrinsics;
    recording.depth_units_per_metre = taken_with->depth_units_per_metre;
    if (rig) {
        const Intrinsics &images = recording.camera, &color = rig->color.pinhole;
        if (images.width != color.width || images.height != color.height)
            return Error{fmt::format("{}/camera.txt: the images are {}x{}, but the colour camera "
                                     "of the calibration has {}x{}",
                                     folder, images.width, images.height, color.width,
                                     color.height),
                         EINVAL};
        recording.camera = color;
        recording.rig = rig;
    }
    const std::string associations = folder + "/associations.txt";
    const Status frames = exists(associations) ? read_associations(associations, recording)
                                               : read_and_pair(folder, recording);
    if (!frames)
        return frames.error();
    if (recording.entries.empty())
        return Error{fmt::format("{}: has no frames{}{}", folder, recording.skipped > 0 ? ": " : "",
                                 recording.skipped_reason),
                     EINVAL};
    if (const std::string path = folder + "/groundtruth.txt"; exists(path)) {
        Result<Trajectory> trajectory = Trajectory::read(path);
        if (!trajectory)
            return trajectory.error();
        recording.ground_truth = *std::move(trajectory);
    }
    return recording;
}

void reorder(Recording &recording, const FrameOrder &order) {
    auto &entries = recording.entries;
    const auto skipped = std::min<std::size_t>(static_cast<std::size_t>(std::max(order.skip, 0)),
                                               entries.size() - 1);
    entries.erase(entries.begin(), entries.begin() + static_cast<std::ptrdiff_t>(skipped));
    const auto every = static_cast<std::size_t>(std::max(order.every, 1));
    const std::size_t kept = (entries.size() + every - 1) / every;
    for (std::size_t i = 0; i < kept; ++i)
        if (i * every != i)
            entries[i] = std::move(entries[i * every]);
    entries.resize(kept);
    if (!order.reverse)
        return;
    const std::int64_t sum_ns = entries.front().t_color_ns + entries.back().t_color_ns;
    std::ranges::reverse(entries);
    for (Recording::Entry &entry : entries) {
        entry.t_color_ns = sum_ns - entry.t_color_ns;
        entry.t_depth_ns = sum_ns - entry.t_depth_ns;
    }
}

Status read_depth_mm(const Recording &recording, std::size_t entry,
                     ImageView<std::uint16_t> depth) {
    assert(depth.width() == recording.tof().width && depth.height() == recording.tof().height);
    if (Status read = read_grey16(recording.entries[entry].depth_path, depth); !read)
        return read;
    const double mm_per_unit = 1000 / recording.depth_units_per_metre;
    if (mm_per_unit == 1)
        return ok();
    for (int v = 0; v < depth.height(); ++v) {
        for (int u = 0; u < depth.width(); ++u) {
            const double mm = depth(u, v) * mm_per_unit + 0.5;
            depth(u, v) = mm < 65536 ? static_cast<std::uint16_t>(mm) : std::uint16_t{0};
        }
    }
    return ok();
}

} // namespace afterglow
