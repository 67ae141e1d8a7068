// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "core/base/result.hpp"
#include "drivers/files/recording.hpp"
#include "eval/datasets/dataset.hpp"

#include <cstdint>
#include <functional>
#include <map>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace afterglow {

/// How one kind of folder is recognised and opened.
struct Layout {
    const char *name;
    const char *signs; ///< what a folder in this layout holds, for a person
    bool (*fits)(const std::string &folder);
    Result<Dataset> (*open)(const std::string &folder);
};

extern const Layout tum_layout;
extern const Layout icl_nuim_layout;
extern const Layout icl_nuim_povray_layout;
extern const Layout corbs_layout;
extern const Layout tum_original_layout;
extern const Layout nyu_v2_layout;
extern const Layout seven_scenes_layout;
extern const Layout open3d_layout;
extern const Layout indoor_rgbd_layout;

/// A dataset of a recording's entries, camera and ground truth, whose files hold what the camera
/// sees: PNG or JPEG images, and registered 16-bit depth PNGs in the recording's units.
Dataset dataset_of(Recording recording);

/// Paths of files by the numbers in their names.
using NumberedFiles = std::map<std::int64_t, std::string>;

/// As above, of the images and depth maps whose number n is the same, taken at n / `per_second`
/// seconds. An image or a map without the other is left out and counted. `recording`: without
/// entries.
Dataset dataset_of(Recording recording, const NumberedFiles &colors, const NumberedFiles &depths,
                   std::int64_t per_second);

/// Reads a PNG or JPEG image, which must have the camera's size, as luma.
Result<Luma> read_luma_sized(const std::string &path, const Intrinsics &camera);
/// Reads a depth PNG, which must have the camera's size, as millimetres.
Result<DepthMap> read_depth_png(const std::string &path, const Intrinsics &camera,
                                double units_per_metre);

/// Whether there is a file or folder of that name, and it may be looked at.
bool exists(const std::string &path);

/// The first line that is not a comment, or nothing where there is none.
std::string first_line(const std::string &path);

/// The names of a folder's own files that `wanted` holds for, in order.
std::vector<std::string> files_in(const std::string &folder,
                                  const std::function<bool(const std::string &name)> &wanted);

/// Larger numbers are no frame's.
inline constexpr std::int64_t max_frame_number = 1'000'000'000;
/// The frame's number that all of `digits` are, from 0 to max_frame_number; nothing if they are
/// none.
std::optional<std::int64_t> frame_number(std::string_view digits);

/// Counts something left out; the first reason is remembered.
void skip(Dataset &dataset, std::string reason);

} // namespace afterglow
