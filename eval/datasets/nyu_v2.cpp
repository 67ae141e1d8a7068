// SPDX-License-Identifier: Apache-2.0
#include "eval/datasets/layout.hpp"
#include "eval/datasets/netpbm.hpp"
#include "eval/datasets/registration.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cerrno>
#include <charconv>
#include <cstdlib>
#include <memory>
#include <optional>

namespace afterglow {
namespace {

// The calibration of the dataset's toolbox (camera_params.m).
constexpr Intrinsics color = {
    518.85790117450188, 519.46961112127485, 325.58244941119034, 253.73616633400465, 640, 480};
constexpr LensDistortion color_lens = {0.20796615318809061, -0.58613825163911781,
                                       7.2231363135888329e-4, 1.0479627195765181e-3,
                                       0.49856986684705107};
constexpr Intrinsics depth = {
    582.62448167737955, 582.69103270988637, 313.04475870804731, 238.44389626620386, 640, 480};
constexpr LensDistortion depth_lens = {-0.099897236553084481, 0.39065324602765344,
                                       1.9290592870229277e-3, -1.9422022475975055e-3,
                                       -0.51031725053400578};

/// The toolbox projects R X + T, where its R is minus the inverse of the calibrated rotation and
/// its T lists t_x t_z t_y. A projection does not change with the sign of the point, so that is
/// the rigid motion -R X - T.
Pose depth_to_color() {
    Eigen::Matrix3d rotation;
    rotation << 9.9997798940829263e-01, 5.0518419386157446e-03, 4.3011152014118693e-03,
        -5.0359919480810989e-03, 9.9998051861143999e-01, -3.6879781309514218e-03,
        -4.3196624923060242e-03, 3.6662365748484798e-03, 9.9998394948385538e-01;
    return {rotation.transpose(), -Eigen::Vector3d(2.5031875059141302e-02, -2.9342312935846411e-04,
                                                   6.6238747008330102e-04)};
}

/// Raw depth is disparity, 11 bits. The toolbox takes what is below 600 as noise, and 2047 is the
/// sensor's word for nothing.
constexpr std::uint16_t nearest_disparity = 600, nothing = 2047;
/// Further than the toolbox's maxDepth the steps of the disparity are wider than 25 cm.
constexpr float furthest = 10;

float metres_of(std::uint16_t disparity) {
    if (disparity < nearest_disparity || disparity >= 1092)
        return 0;
    const float metres = 351.3f / (1092.5f - static_cast<float>(disparity));
    return metres <= furthest ? metres : 0;
}

/// An image or depth map never goes with one further away in time; cameras at 30 Hz have one
/// within 17 ms, unless frames were lost.
constexpr std::int64_t tolerance_ns = 50'000'000;

struct Stamped {
    std::int64_t t_ns;
    std::string path;
};

/// The time in a name such as d-1294886362.238178-3118787619.pgm: seconds.
std::optional<std::int64_t> time_of(const std::string &name) {
    const std::size_t dash = name.find('-', 2);
    if (dash == std::string::npos)
        return std::nullopt;
    double seconds = 0;
    const auto [end, problem] = std::from_chars(name.data() + 2, name.data() + dash, seconds);
    if (problem != std::errc() || end != name.data() + dash || !(seconds >= 0 && seconds < 9e9))
        return std::nullopt;
    return static_cast<std::int64_t>(seconds * 1e6 + 0.5) * 1000;
}

bool is_depth(const std::string &name) {
    return name.starts_with("d-") && name.ends_with(".pgm");
}
bool is_color(const std::string &name) {
    return name.starts_with("r-") && name.ends_with(".ppm");
}

std::vector<Stamped> list(const std::string &folder, bool (*wanted)(const std::string &),
                          Dataset &dataset) {
    std::vector<Stamped> files;
    for (const std::string &name : files_in(folder, wanted)) {
        if (const std::optional<std::int64_t> t_ns = time_of(name))
            files.push_back({*t_ns, folder + "/" + name});
        else
            skip(dataset, folder + "/" + name + ": its name has no time");
    }
    std::stable_sort(files.begin(), files.end(),
                     [](const Stamped &a, const Stamped &b) { return a.t_ns < b.t_ns; });
    return files;
}

/// The toolbox's pairing (get_synched_frames.m): each depth map goes with the image nearest in
/// time. Of several that chose one image the nearest has it; the others are left out, as are
/// images that none chose.
void pair(const std::vector<Stamped> &colors, const std::vector<Stamped> &depths,
          Dataset &dataset) {
    const auto gap = [](const Stamped &a, const Stamped &b) { return std::abs(a.t_ns - b.t_ns); };
    std::vector<const Stamped *> depth_of(colors.size(), nullptr);
    std::size_t i = 0;
    for (const Stamped &map : depths) {
        while (i + 1 < colors.size() && gap(map, colors[i + 1]) <= gap(map, colors[i]))
            ++i;
        if (colors.empty() || gap(map, colors[i]) > tolerance_ns) {
            skip(dataset, map.path + ": has no image within 50 ms");
            continue;
        }
        const Stamped *&kept = depth_of[i];
        const bool nearer = kept == nullptr || gap(map, colors[i]) < gap(*kept, colors[i]);
        if (kept != nullptr)
            skip(dataset, (nearer ? kept : &map)->path + ": its image has a nearer depth map");
        if (nearer)
            kept = &map;
    }
    for (i = 0; i < colors.size(); ++i) {
        if (depth_of[i] != nullptr)
            dataset.frames.push_back({colors[i].t_ns, depth_of[i]->t_ns, colors[i].path,
                                      depth_of[i]->path, std::nullopt});
        else
            skip(dataset, colors[i].path + ": is not the nearest image of any depth map");
    }
}

template <class T>
Status check_size(const std::string &path, const Image<T> &image, const Intrinsics &camera) {
    if (image.width() == camera.width && image.height() == camera.height)
        return ok();
    return Error{fmt::format("{}: is {} x {} pixels instead of {} x {}", path, image.width(),
                             image.height(), camera.width, camera.height),
                 EINVAL};
}

Result<Luma> read_luma(const std::string &path) {
    const Result<Luma> luma = read_ppm_luma(path);
    if (!luma)
        return luma.error();
    if (Status sized = check_size(path, *luma, color); !sized)
        return sized.error();
    return undistorted(*luma, color, color_lens);
}

Result<DepthMap> read_depth(const std::string &path, const DepthRegistration &registration) {
    // The recorder wrote the numbers as they lay in memory, against the format; the toolbox swaps.
    const Result<Image<std::uint16_t>> raw = read_pgm16(path, std::endian::little);
    if (!raw)
        return raw.error();
    if (Status sized = check_size(path, *raw, depth); !sized)
        return sized.error();
    const std::uint16_t highest = *std::max_element(raw->pixels().begin(), raw->pixels().end());
    if (highest > nothing)
        return Error{fmt::format("{}: holds {}, and disparities have 11 bits: its bytes are not in "
                                 "the dataset's order, low byte first",
                                 path, highest),
                     EINVAL};
    Image<float> metres(depth.width, depth.height);
    std::transform(raw->pixels().begin(), raw->pixels().end(), metres.pixels().begin(), metres_of);
    return registration.registered(metres.view());
}

bool fits(const std::string &folder) {
    return !files_in(folder, is_depth).empty() && !files_in(folder, is_color).empty();
}

Result<Dataset> open(const std::string &folder) {
    Dataset dataset;
    dataset.camera = color;
    const std::vector<Stamped> colors = list(folder, is_color, dataset);
    pair(colors, list(folder, is_depth, dataset), dataset);
    dataset.read_luma = read_luma;
    dataset.read_depth = [registration = std::make_shared<const DepthRegistration>(
                              depth, depth_lens, depth_to_color(), color)](
                             const std::string &path) { return read_depth(path, *registration); };
    return dataset;
}

} // namespace

const Layout nyu_v2_layout = {"nyu-v2", "d-TIME-TICK.pgm and r-TIME-TICK.ppm", fits, open};

} // namespace afterglow
