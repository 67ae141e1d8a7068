// SPDX-License-Identifier: Apache-2.0
#include "eval/datasets/layout.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cctype>
#include <filesystem>
#include <optional>
#include <string_view>
#include <utility>

namespace afterglow {
namespace {

namespace fs = std::filesystem;

/// A Kinect v1 as its driver registers depth to colour.
constexpr RecordingCamera nominal = {{525, 525, 319.5, 239.5, 640, 480}, 1000};
/// The robot's cameras were sampled together with the overhead ones.
constexpr std::int64_t samples_per_second = 10;

enum class Kind { color, depth };

/// What a file is, and its number: from the words "depth" and "rgb" or "color" in its name or in
/// the name of the `subfolder` it lies in, and from the last digits of its name.
std::optional<std::pair<Kind, std::int64_t>> identify(const fs::path &file,
                                                      const std::string &subfolder) {
    std::string words = subfolder + "/" + file.stem().string();
    std::transform(words.begin(), words.end(), words.begin(),
                   [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
    const auto has = [&](const char *word) { return words.find(word) != std::string::npos; };
    const std::string type = file.extension().string();
    const bool depth = has("depth");
    if ((!depth && !has("rgb") && !has("color")) ||
        (type != ".png" && (depth || (type != ".jpg" && type != ".jpeg"))))
        return std::nullopt;
    const std::string stem = file.stem().string();
    const std::size_t last = stem.find_last_of("0123456789");
    if (last == std::string::npos)
        return std::nullopt;
    const std::size_t before = stem.find_last_not_of("0123456789", last);
    const std::size_t first = before == std::string::npos ? 0 : before + 1;
    const auto number = frame_number(std::string_view(stem).substr(first, last + 1 - first));
    if (!number)
        return std::nullopt;
    return std::pair(depth ? Kind::depth : Kind::color, *number);
}

struct Found {
    NumberedFiles color, depth;
};

/// The files of a folder and of the folders in it.
Found find_images(const std::string &folder) {
    Found found;
    std::error_code problem;
    for (fs::recursive_directory_iterator file(folder, problem), end; !problem && file != end;
         file.increment(problem)) {
        const bool below = file.depth() == 1;
        if (below)
            file.disable_recursion_pending();
        const fs::path &path = file->path();
        if (const auto image = identify(path, below ? path.parent_path().filename().string() : ""))
            (image->first == Kind::depth ? found.depth : found.color)
                .emplace(image->second, path.string());
    }
    return found;
}

bool fits(const std::string &folder) {
    const Found found = find_images(folder);
    return !found.color.empty() && !found.depth.empty();
}

Result<Dataset> open(const std::string &folder) {
    Recording recording;
    const bool has_camera = exists(folder + "/camera.txt");
    const Result<RecordingCamera> camera =
        has_camera ? read_recording_camera(folder) : Result<RecordingCamera>(nominal);
    if (!camera)
        return camera.error();
    recording.camera = camera->intrinsics;
    recording.depth_units_per_metre = camera->depth_units_per_metre;
    const Found found = find_images(folder);
    Dataset dataset =
        dataset_of(std::move(recording), found.color, found.depth, samples_per_second);
    dataset.assumed =
        fmt::format("{}numbers count tenths of a second, and depth is registered to colour",
                    has_camera ? ""
                               : "there is no camera.txt: a Kinect's nominal camera and "
                                 "depth in millimetres were assumed; ");
    return dataset;
}

} // namespace

const Layout indoor_rgbd_layout = {
    "indoor-rgbd", "numbered images whose names or folders say rgb or color, and depth", fits,
    open};

} // namespace afterglow
