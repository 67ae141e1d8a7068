// SPDX-License-Identifier: Apache-2.0
#include "config/calibration_file.hpp"
#include "eval/datasets/layout.hpp"

#include <fmt/format.h>

#include <cerrno>
#include <cstdlib>
#include <fstream>
#include <optional>

namespace afterglow {
namespace {

/// The colour cameras of the benchmark's three Kinects, from its page "File Formats". The images
/// are left as they were recorded, bent by the lens (k1 = 0.26 and 0.23 for fr1 and fr2).
constexpr Intrinsics fr1 = {517.3, 516.5, 318.6, 255.3, 640, 480};
constexpr Intrinsics fr2 = {520.9, 521.0, 325.1, 249.7, 640, 480};
constexpr Intrinsics fr3 = {535.4, 539.2, 320.1, 247.6, 640, 480};
constexpr double units_per_metre = 5000;

bool is_recording(const std::string &folder) {
    const auto has = [&](const char *name) { return exists(folder + name); };
    return has("/camera.txt") &&
           (has("/associations.txt") || (has("/rgb.txt") && has("/depth.txt")));
}

Result<Dataset> open_as_it_is(const std::string &folder) {
    Result<Recording> recording = open_recording(folder);
    if (!recording)
        return recording.error();
    Dataset dataset = dataset_of(*std::move(recording));
    dataset.calibration = calibration_of_recording(folder);
    return dataset;
}

/// Which Kinect took a sequence: from the folder's name, or else from the bag that the comments of
/// rgb.txt name.
std::optional<Intrinsics> camera_of(const std::string &folder) {
    std::string text = folder_name(folder);
    std::ifstream rgb(folder + "/rgb.txt");
    for (std::string line; std::getline(rgb, line) && line.starts_with('#');)
        text += line;
    for (const auto &[number, camera] : {std::pair{'1', fr1}, {'2', fr2}, {'3', fr3}}) {
        for (const char *prefix : {"freiburg", "fr"}) {
            if (text.find(fmt::format("{}{}", prefix, number)) != std::string::npos)
                return camera;
        }
    }
    return std::nullopt;
}

bool is_original(const std::string &folder) {
    return !exists(folder + "/camera.txt") && exists(folder + "/rgb.txt") &&
           exists(folder + "/depth.txt");
}

Result<Dataset> open_original(const std::string &folder) {
    const std::optional<Intrinsics> camera = camera_of(folder);
    if (!camera)
        return Error{fmt::format("{}: has no camera.txt, and neither its name nor rgb.txt says "
                                 "whether it is of freiburg1, freiburg2 or freiburg3",
                                 folder),
                     EINVAL};
    Result<Recording> recording = open_recording(folder, RecordingCamera{*camera, units_per_metre});
    if (!recording)
        return recording.error();
    return dataset_of(*std::move(recording));
}

} // namespace

const Layout tum_layout = {"tum", "camera.txt and associations.txt or rgb.txt and depth.txt",
                           is_recording, open_as_it_is};
const Layout tum_original_layout = {"tum-original", "rgb.txt and depth.txt", is_original,
                                    open_original};

} // namespace afterglow
