// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "core/base/camera.hpp"
#include "core/base/image.hpp"
#include "core/base/result.hpp"
#include "core/base/rigid_motion.hpp"

#include <cstddef>
#include <cstdint>
#include <functional>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace afterglow {

/// A sequence of a published RGB-D dataset, whatever its layout: pairs of images and depth maps,
/// the depth registered to the image unless `calibration` is there. docs/datasets.md tells how each
/// layout is read.
struct Dataset {
    struct Frame {
        std::int64_t t_ns = 0;       ///< of the image; not negative
        std::int64_t t_depth_ns = 0; ///< of the depth map
        std::string color_path;
        std::string depth_path;
        std::optional<Pose> camera_to_world; ///< of the image's camera, x right, y down, z forward

        /// t_depth_ns; the image's time where the two are too far apart for a recording.
        std::int64_t depth_time_ns() const;
    };

    std::string layout;  ///< its name, as open_dataset() takes it
    std::string assumed; ///< a sentence on what the dataset does not say and was assumed; or empty
    /// The file with the calibration of two cameras, whose frames only replay reads; or empty.
    std::string calibration;
    Intrinsics camera;         ///< of what read_luma() and read_depth() return
    std::vector<Frame> frames; ///< at least one; t_ns rises
    /// Images and depth maps that were left out, and why the first of them was.
    std::size_t skipped = 0;
    std::string skipped_reason;

    /// Read a frame's files: an image, and millimetres along Z with 0 = no depth. Both have the
    /// camera's size. Errors begin with the file's name.
    std::function<Result<Luma>(const std::string &color_path)> read_luma;
    std::function<Result<DepthMap>(const std::string &depth_path)> read_depth;
};

/// Opens a folder in any layout of dataset_layouts(), recognised by its files; reads text files,
/// and of the images no more than it takes to tell layouts apart. `layout` forces one by its name.
Result<Dataset> open_dataset(const std::string &folder, std::string_view layout = {});

/// What refuses a recording of two cameras where depth must be registered to the images.
Error not_registered(const std::string &folder, const std::string &calibration);

/// "path/to/name/" and "path/to/name" are both "name".
std::string folder_name(const std::string &folder);

/// The layouts that are read, in the order in which they are tried.
std::vector<std::string_view> dataset_layouts();

} // namespace afterglow
