// SPDX-License-Identifier: Apache-2.0
#include "drivers/files/write_recording.hpp"

#include "drivers/files/image_file.hpp"
#include "drivers/files/text_fields.hpp"

#include <Eigen/Geometry>
#include <fmt/format.h>
#include <system_error>

#include <cassert>
#include <cerrno>
#include <filesystem>

namespace afterglow {
namespace {

constexpr double depth_units_per_metre = 1000;

} // namespace

Result<RecordingWriter> RecordingWriter::create(const std::string &folder, const Intrinsics &camera,
                                                const std::optional<Intrinsics> &tof) {
    namespace fs = std::filesystem;
    std::error_code problem;
    if (folder.empty())
        return Error{"the name of a folder is empty", EINVAL};
    for (const char *name : {"/rgb", "/depth", "/camera.txt", "/rgb.txt", "/depth.txt",
                             "/associations.txt", "/groundtruth.txt", "/calibration.toml"}) {
        if (fs::exists(folder + name, problem))
            return Error{fmt::format("{}: holds a recording already", folder), EEXIST};
    }
    for (const char *images : {"/rgb", "/depth"}) {
        fs::create_directories(folder + images, problem);
        if (problem)
            return Error{fmt::format("{}{}: {}", folder, images, problem.message()),
                         problem.value()};
    }
    RecordingWriter writer(folder, camera, tof.value_or(camera));
    std::ofstream camera_file(folder + "/camera.txt");
    camera_file << "# fx fy cx cy width height depth_units_per_metre\n"
                << fmt::format("{} {} {} {} {} {} {}\n", camera.fx, camera.fy, camera.cx, camera.cy,
                               camera.width, camera.height, depth_units_per_metre);
    writer.associations_.open(folder + "/associations.txt");
    writer.associations_ << "# t_color color_file t_depth depth_file\n" << std::flush;
    writer.ground_truth_.open(folder + "/groundtruth.txt");
    writer.ground_truth_ << "# camera to world: t tx ty tz qx qy qz qw\n" << std::flush;
    if (!camera_file.flush() || !writer.associations_ || !writer.ground_truth_)
        return Error{fmt::format("{}: could not be written", folder), EIO};
    return writer;
}

Status RecordingWriter::add(std::int64_t t_ns, LumaView luma, std::int64_t t_depth_ns,
                            DepthView depth_mm, const std::optional<Pose> &camera_to_world) {
    assert(t_ns >= 0 && t_depth_ns >= 0);
    assert(luma.width() == camera_.width && luma.height() == camera_.height);
    assert(depth_mm.width() == tof_.width && depth_mm.height() == tof_.height);
    const std::string name = fmt::format("{:06}.png", count_);
    if (Status written = write_png(fmt::format("{}/rgb/{}", folder_, name), luma); !written)
        return written;
    if (Status written = write_png(fmt::format("{}/depth/{}", folder_, name), depth_mm); !written)
        return written;
    const std::string t = seconds_text(t_ns);
    associations_ << fmt::format("{} rgb/{} {} depth/{}\n", t, name, seconds_text(t_depth_ns), name)
                  << std::flush;
    if (camera_to_world) {
        const Eigen::Quaterniond q(camera_to_world->R);
        const Eigen::Vector3d &p = camera_to_world->T;
        ground_truth_ << fmt::format("{} {} {} {} {} {} {} {}\n", t, p.x(), p.y(), p.z(), q.x(),
                                     q.y(), q.z(), q.w())
                      << std::flush;
    }
    if (!associations_ || !ground_truth_)
        return Error{fmt::format("{}: could not be written", folder_), EIO};
    ++count_;
    return ok();
}

} // namespace afterglow
