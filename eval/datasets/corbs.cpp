// SPDX-License-Identifier: Apache-2.0
#include "drivers/files/image_file.hpp"
#include "eval/datasets/layout.hpp"
#include "eval/datasets/registration.hpp"
#include "eval/datasets/scale.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <memory>

namespace afterglow {
namespace {

/// The camera of the archives *_pre_registereddata: depth and colour at 640 x 480, which are the
/// middle of the Kinect v2's 1920 x 1080, shrunk by 9/4.
constexpr Intrinsics color = {468.60, 468.61, 318.27, 243.99, 640, 480};
/// The Kinect v2's depth camera, for the archives *_raw; its images have no distortion.
constexpr Intrinsics raw_depth = {363.58, 363.53, 250.32, 212.55, 512, 424};
constexpr double units_per_metre = 5000;
constexpr int raw_width = 1920, raw_height = 1080;

/// Where the colour camera of a Kinect v2 is, as its maker built it.
Pose raw_depth_to_color() {
    return {Eigen::Matrix3d::Identity(), {-0.052, 0, 0}};
}

bool fits(const std::string &folder) {
    if (exists(folder + "/camera.txt") || !exists(folder + "/rgb.txt") ||
        !exists(folder + "/depth.txt"))
        return false;
    return first_line(folder + "/rgb.txt").find('\\') != std::string::npos ||
           folder_name(folder).find("registereddata") != std::string::npos;
}

/// The poses are in an archive of their own: E1_Trajectory beside E1_raw.
std::string ground_truth_path(const std::string &folder) {
    const std::string name = folder_name(folder);
    return fmt::format("{}/../{}_Trajectory/groundtruth.txt", folder,
                       name.substr(0, name.find('_')));
}

Result<Luma> read_raw_luma(const std::string &path) {
    Luma full(raw_width, raw_height);
    if (Status read = read_luma(path, full.view()); !read)
        return read.error();
    return cropped_and_shrunk(full, color.width, color.height);
}

Result<DepthMap> read_raw_depth(const std::string &path, const DepthRegistration &registration) {
    Image<std::uint16_t> raw(raw_depth.width, raw_depth.height);
    if (Status read = read_grey16(path, raw.view()); !read)
        return read.error();
    Image<float> metres(raw.width(), raw.height());
    std::transform(raw.pixels().begin(), raw.pixels().end(), metres.pixels().begin(),
                   [](std::uint16_t units) { return static_cast<float>(units / units_per_metre); });
    return registration.registered(metres.view());
}

/// Whether the depth maps are as wide as the sensor; by the first that can be read.
bool is_raw(const Recording &recording) {
    for (const Recording::Entry &entry : recording.entries) {
        if (const Result<Image<std::uint16_t>> depth = read_grey16(entry.depth_path))
            return depth->width() == raw_depth.width;
    }
    return false;
}

Result<Dataset> open(const std::string &folder) {
    Result<Recording> recording = open_recording(folder, RecordingCamera{color, units_per_metre});
    if (!recording)
        return recording.error();
    if (const std::string path = ground_truth_path(folder);
        recording->ground_truth.empty() && exists(path)) {
        Result<Trajectory> poses = Trajectory::read(path);
        if (!poses)
            return poses.error();
        recording->ground_truth = *std::move(poses);
    }
    const bool raw = is_raw(*recording);
    Dataset dataset = dataset_of(*std::move(recording));
    if (!raw)
        return dataset;
    dataset.read_luma = read_raw_luma;
    dataset.read_depth =
        [registration = std::make_shared<const DepthRegistration>(
             raw_depth, LensDistortion{}, raw_depth_to_color(), color)](const std::string &path) {
            return read_raw_depth(path, *registration);
        };
    dataset.assumed = "the raw archives do not say where the colour camera is: 52 mm to the right "
                      "of the depth camera and parallel to it was assumed";
    return dataset;
}

} // namespace

const Layout corbs_layout = {"corbs", "rgb.txt and depth.txt with paths such as rgb\\1.png", fits,
                             open};

} // namespace afterglow
