// SPDX-License-Identifier: Apache-2.0
#include "drivers/files/read_file.hpp"
#include "eval/datasets/layout.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <charconv>
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
    const auto number = [](const nlohmann::json &value) {
        return value.is_number() ? value.get<double>() : 0;
    };
    const auto matrix = json.value("intrinsic_matrix", nlohmann::json());
    if (!matrix.is_array() || matrix.size() != 9)
        return refused("intrinsic_matrix is not an array of 9 numbers");
    const std::array camera = {number(matrix[0]),
                               number(matrix[4]),
                               number(matrix[6]),
                               number(matrix[7]),
                               number(json.value("width", nlohmann::json())),
                               number(json.value("height", nlohmann::json()))};
    if (const std::string problem = camera_problem(camera); !problem.empty())
        return refused(problem);
    const auto [fx, fy, cx, cy, width, height] = camera;
    return Intrinsics{fx, fy, cx, cy, static_cast<int>(width), static_cast<int>(height)};
}

/// The numbered files of a folder, by number.
NumberedFiles numbered(const std::string &folder, const std::vector<std::string_view> &types) {
    NumberedFiles found;
    for (const std::string &name : files_in(folder, [](const std::string &) { return true; })) {
        std::int64_t number = 0;
        const char *const end = name.data() + name.size();
        const auto [stop, problem] = std::from_chars(name.data(), end, number);
        if (problem == std::errc() && number >= 0 && number <= 1'000'000'000 &&
            std::ranges::count(types, std::string_view(stop, end)) > 0)
            found.emplace(number, folder + "/" + name);
    }
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
    dataset.assumed = fmt::format("numbers count frames, {} a second, and depth is in millimetres",
                                  frames_per_second);
    return dataset;
}

} // namespace

const Layout open3d_layout = {
    "open3d", "color/ and depth/ with camera_intrinsic.json or intrinsic.json", fits, open};

} // namespace afterglow
