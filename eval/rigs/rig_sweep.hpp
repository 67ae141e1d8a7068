// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "core/rig/rig_geometry.hpp"

#include <span>
#include <string>
#include <string_view>
#include <vector>

namespace afterglow {

/// A camera of the sweep, named by its size.
struct SweptCamera {
    std::string_view name;
    CameraModel model;
};

/// Like modules in the market: about 62 degrees wide, and as wide as the image of the registered
/// rig that they are compared with.
std::span<const SweptCamera> swept_tof_cameras();
/// 65 and 71 degrees wide with Brown-Conrady lenses, and a fisheye of 110 degrees.
std::span<const SweptCamera> swept_color_cameras();
/// Millimetres.
std::span<const int> swept_baselines();
/// What is published: "color", "tof", or "own": a pinhole of 640x480 at the colour camera's place.
std::span<const std::string_view> swept_views();

/// One row of the sweep.
struct SweptRig {
    SweptCamera tof;
    SweptCamera color;
    int baseline_mm;
    std::string_view published;

    /// The TOF camera beside the colour camera, turned by a degree as glued modules are; the
    /// images' rows are read in 20 ms, and depth is exposed 5 ms after them.
    RigGeometry geometry() const;
    /// Its four words, as select_rigs() takes them: "224x172", "1280x720", "25mm", "own".
    std::vector<std::string> words() const;
};

/// All words that tell rows of the sweep apart.
std::vector<std::string> sweep_words();
/// The rows that have, of each of their four properties that `words` name, one that it names.
std::vector<SweptRig> select_rigs(const std::vector<std::string> &words);

} // namespace afterglow
