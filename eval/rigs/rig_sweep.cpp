// SPDX-License-Identifier: Apache-2.0
#include "eval/rigs/rig_sweep.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>

namespace afterglow {
namespace {

constexpr double readout_s = 0.02, delay_s = 0.005;
const Eigen::Vector3d turn(0.010, -0.015, 0.008); // radians

CameraModel pinhole_camera(int width, int height, double f) {
    return {.pinhole = {f, f, (width - 1) / 2.0, (height - 1) / 2.0, width, height}};
}

/// The centre is never quite in the middle.
CameraModel camera(int width, int height, double f, Lens lens,
                   const std::array<double, 8> &distortion) {
    CameraModel model = pinhole_camera(width, height, f);
    model.pinhole.cx += 0.01 * width;
    model.pinhole.cy -= 0.008 * width;
    model.lens = lens;
    model.distortion = distortion;
    return model;
}

} // namespace

std::span<const SweptCamera> swept_tof_cameras() {
    static const SweptCamera all[] = {
        {"224x172", camera(224, 172, 186, Lens::brown_conrady, {-0.1, 0.02, 0.0005, -0.0003})},
        {"320x240", camera(320, 240, 265, Lens::brown_conrady, {-0.05, 0.01})},
        {"640x576", camera(640, 576, 525, Lens::brown_conrady,
                           {0.45, -2.5, 0.0004, -0.0002, 1.4, 0.33, -2.3, 1.3})},
    };
    return all;
}

std::span<const SweptCamera> swept_color_cameras() {
    static const SweptCamera all[] = {
        {"640x480", camera(640, 480, 500, Lens::brown_conrady, {0.05, -0.1, 0.0008, -0.0005})},
        {"1280x720", camera(1280, 720, 900, Lens::brown_conrady, {-0.3, 0.1, 0.0005, 0, -0.015})},
        {"1920x1080", camera(1920, 1080, 1010, Lens::kannala_brandt, {-0.02, 0.003, -0.001})},
    };
    return all;
}

std::span<const int> swept_baselines() {
    static constexpr int all[] = {5, 25, 80};
    return all;
}

std::span<const std::string_view> swept_views() {
    static constexpr std::string_view all[] = {"color", "tof", "own"};
    return all;
}

RigGeometry SweptRig::geometry() const {
    const double baseline = 0.001 * baseline_mm;
    const RigCalibration rig{
        .color = color.model,
        .tof = tof.model,
        .tof_from_color = {rotation(turn), {-baseline, 0.1 * baseline, 0}},
        .tof_delay_s = delay_s,
        .readout_s = readout_s,
    };
    if (published == "color")
        return {rig, rig.color, {}};
    if (published == "tof")
        return {rig, rig.tof, rig.tof_from_color};
    return {rig, pinhole_camera(640, 480, 525), {}};
}

std::vector<std::string> SweptRig::words() const {
    return {std::string(tof.name), std::string(color.name), fmt::format("{}mm", baseline_mm),
            std::string(published)};
}

std::vector<std::string> sweep_words() {
    std::vector<std::string> all;
    for (const SweptRig &rig : select_rigs({})) {
        for (const std::string &word : rig.words()) {
            if (std::ranges::find(all, word) == all.end())
                all.push_back(word);
        }
    }
    return all;
}

std::vector<SweptRig> select_rigs(const std::vector<std::string> &words) {
    const auto names = [&](const std::string &word) {
        return std::ranges::find(words, word) != words.end();
    };
    std::vector<SweptRig> all;
    for (const SweptCamera &tof : swept_tof_cameras())
        for (const SweptCamera &color : swept_color_cameras())
            for (const int baseline : swept_baselines())
                for (const std::string_view view : swept_views())
                    all.push_back({tof, color, baseline, view});
    // Of each property the words that are named of it; none of them named: all.
    const std::size_t properties = all.front().words().size();
    for (std::size_t i = 0; i < properties; ++i) {
        const auto has_named = [&](const SweptRig &rig) { return names(rig.words()[i]); };
        if (std::ranges::any_of(all, has_named))
            std::erase_if(all, std::not_fn(has_named));
    }
    return all;
}

} // namespace afterglow
