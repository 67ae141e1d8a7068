// SPDX-License-Identifier: Apache-2.0
#include "core/base/median.hpp"
#include "core/base/read_file.hpp"
#include "eval/datasets/icl_nuim.hpp"
#include "eval/datasets/layout.hpp"

#include <fmt/format.h>

#include <cctype>
#include <cerrno>
#include <charconv>
#include <filesystem>

namespace afterglow {
namespace {

namespace fs = std::filesystem;

constexpr const Intrinsics &camera = icl_nuim_camera;
/// The rooms are a few metres wide: a file whose median is beyond this is not in metres.
constexpr double furthest_median = 50;

bool is_depth(const std::string &name) {
    return name.starts_with("scene_") && name.ends_with(".depth");
}

/// The number N of scene_00_N.depth.
std::optional<std::int64_t> frame_of(const std::string &name) {
    const std::size_t begin = name.rfind('_') + 1, end = name.rfind('.');
    return frame_number(std::string_view(name).substr(begin, end - begin));
}

/// Reads distances along the rays, metres, as text; row by row.
Result<std::vector<double>> read_distances(const std::string &path) {
    const Result<std::string> text = read_file(path);
    if (!text)
        return text.error();
    const std::size_t expected =
        static_cast<std::size_t>(camera.width) * static_cast<std::size_t>(camera.height);
    std::vector<double> distances;
    distances.reserve(expected);
    const char *at = text->data(), *const end = at + text->size();
    for (;;) {
        while (at != end && std::isspace(static_cast<unsigned char>(*at)))
            ++at;
        if (at == end)
            break;
        double distance = 0;
        const auto [stop, problem] = std::from_chars(at, end, distance);
        if (problem == std::errc::invalid_argument)
            return Error{fmt::format("{}: number {} is not a number", path, distances.size() + 1),
                         EINVAL};
        distances.push_back(problem == std::errc() ? distance : 0);
        at = stop;
    }
    if (distances.size() != expected)
        return Error{fmt::format("{}: has {} distances instead of {} x {}", path, distances.size(),
                                 camera.width, camera.height),
                     EINVAL};
    return distances;
}

Result<DepthMap> read_depth(const std::string &path) {
    const Result<std::vector<double>> distances = read_distances(path);
    if (!distances)
        return distances.error();
    if (median(*distances) > furthest_median)
        return Error{fmt::format("{}: half of the distances are beyond {} m: they are expected in "
                                 "metres",
                                 path, furthest_median),
                     EINVAL};
    DepthMap depth(camera.width, camera.height);
    auto distance = distances->begin();
    for (int v = 0; v < camera.height; ++v) {
        for (int u = 0; u < camera.width; ++u, ++distance) {
            const double ray = camera.back_project(u, v, 1).norm();
            const double mm = *distance / ray * 1000 + 0.5;
            depth(u, v) = mm > 0 && mm < 65536 ? static_cast<std::uint16_t>(mm) : std::uint16_t{0};
        }
    }
    return depth;
}

bool fits(const std::string &folder) {
    return !files_in(folder, is_depth).empty();
}

Result<Dataset> open(const std::string &folder) {
    Dataset dataset;
    dataset.camera = camera;
    dataset.read_luma = [](const std::string &path) { return read_luma_sized(path, camera); };
    dataset.read_depth = read_depth;
    for (const std::string &name : files_in(folder, is_depth)) {
        const std::optional<std::int64_t> frame = frame_of(name);
        const std::string depth = folder + "/" + name;
        const std::string image = fs::path(depth).replace_extension(".png").string();
        if (!frame)
            skip(dataset, depth + ": its name has no frame number");
        else if (!exists(image))
            skip(dataset, depth + ": has no image of the same name");
        else
            dataset.frames.push_back(
                {icl_nuim_time_ns(*frame), icl_nuim_time_ns(*frame), image, depth, std::nullopt});
    }
    return dataset;
}

} // namespace

const Layout icl_nuim_povray_layout = {"icl-nuim-povray", "scene_00_0000.depth and .png", fits,
                                       open};

} // namespace afterglow
