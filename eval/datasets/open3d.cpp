// SPDX-License-Identifier: Apache-2.0
#include "core/base/read_file.hpp"
#include "eval/datasets/layout.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <nlohmann/json.hpp>
#include <optional>
#include <string_view>
#include <utility>

namespace afterglow {
namespace {

constexpr std::int64_t frames_per_second = 30;
constexpr double units_per_metre = 1000;

/// The camera's file, as the recorder of RealSense cameras and that of Azure Kinects call it.
constexpr std::array camera_files = {"camera_intrinsic.json", "intrinsic.json"};

std::optional<std::string> camera_file(const std::string &folder) {
    for (const char *const name : camera_files)
        if (std::string path = folder + "/" + name; exists(path))
            return path;
    return std::nullopt;
}

/// Width, height, and the camera's matrix column by column.
Result<Intrinsics> read_camera(const std::string &path) {
    const Result<std::string> text = read_file(path);
    if (!text)
        return text.error();
    const auto json = nlohmann::json::parse(*text, nullptr, false);
    const auto refused = [&](std::string_view why) {
        return Error{fmt::format("{}: {}", path, why), EINVAL};
    };
    if (!json.is_object())
        return refused("is not a JSON object");
    const auto matrix = json.value("intrinsic_matrix", nlohmann::json());
    const auto is_number = [](const nlohmann::json &value) { return value.is_number(); };
    if (!matrix.is_array() || matrix.size() != 9 || !std::ranges::all_of(matrix, is_number))
        return refused("intrinsic_matrix is not an array of 9 numbers");
    const auto at = [&](std::size_t i) { return matrix[i].get<double>(); };
    const auto side = [&](const char *key) {
        const auto value = json.value(key, nlohmann::json());
        return is_number(value) ? value.get<double>() : 0; // which no image has
    };
    const std::array camera = {at(0), at(4), at(6), at(7), side("width"), side("height")};
    if (const std::string problem = camera_problem(camera); !problem.empty())
        return refused(problem);
    const auto [fx, fy, cx, cy, width, height] = camera;
    return Intrinsics{fx, fy, cx, cy, static_cast<int>(width), static_cast<int>(height)};
}

/// The files of a folder that are called by a number and one of `types`, such as ".png".
NumberedFiles numbered(const std::string &folder, const std::vector<std::string_view> &types) {
    const auto number_of = [](std::string_view name, std::string_view type) {
        return name.ends_with(type) ? frame_number(name.substr(0, name.size() - type.size()))
                                    : std::nullopt;
    };
    NumberedFiles found;
    for (const std::string &name : files_in(folder, [](const std::string &) { return true; }))
        for (const std::string_view type : types)
            if (const auto number = number_of(name, type))
                found.emplace(*number, folder + "/" + name);
    return found;
}

bool fits(const std::string &folder) {
    return camera_file(folder) && exists(folder + "/color") && exists(folder + "/depth");
}

Result<Dataset> open(const std::string &folder) {
    const std::optional<std::string> file = camera_file(folder);
    if (!file)
        return Error{fmt::format("{}: has no {}", folder, fmt::join(camera_files, " or ")), ENOENT};
    const Result<Intrinsics> camera = read_camera(*file);
    if (!camera)
        return camera.error();
    Recording recording;
    recording.camera = *camera;
    recording.depth_units_per_metre = units_per_metre;
    Dataset dataset =
        dataset_of(std::move(recording), numbered(folder + "/color", {".jpg", ".png"}),
                   numbered(folder + "/depth", {".png"}), frames_per_second);
    dataset.assumed = fmt::format("the layout tells neither times nor the unit of depth: {} frames "
                                  "a second and millimetres were assumed",
                                  frames_per_second);
    return dataset;
}

} // namespace

const Layout open3d_layout = {
    "open3d", "color/ and depth/ with camera_intrinsic.json or intrinsic.json", fits, open};

} // namespace afterglow
