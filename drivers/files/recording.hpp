// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "core/base/camera.hpp"
#include "core/base/image.hpp"
#include "core/base/result.hpp"
#include "core/base/rig_calibration.hpp"
#include "drivers/files/trajectory.hpp"

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

namespace afterglow {

/// An RGB-D recording in the layout of the TUM benchmark: a folder with
///
///     camera.txt         fx fy cx cy width height depth_units_per_metre
///     associations.txt   t_color color_file t_depth depth_file     or, without it, both of
///     rgb.txt depth.txt  t file
///     groundtruth.txt    camera to world poses (optional; drivers/files/trajectory.hpp)
///
///     calibration.toml   of two cameras (optional; config/calibration_file.hpp)
///
/// Times in seconds, files relative to the folder and within it, `#` begins a comment. Without a
/// calibration depth is registered to colour; with one it is as the TOF camera gives it.
struct Recording {
    struct Entry {
        std::int64_t t_color_ns = 0;
        std::string color_path; ///< ready to open
        std::int64_t t_depth_ns = 0;
        std::string depth_path;
    };

    std::string folder;
    Intrinsics camera;                 ///< of the images
    std::optional<RigCalibration> rig; ///< nothing: depth is registered to the images
    double depth_units_per_metre = 0;
    std::vector<Entry> entries; ///< at least one; t_color_ns rises
    /// Lines that were left out: their time was not later than the one before, or an image had no
    /// depth map within recording_tolerance_ns. The reason names the first of them.
    std::size_t skipped = 0;
    std::string skipped_reason;
    Trajectory ground_truth; ///< empty where it is not known

    /// Of the depth maps.
    const Intrinsics &tof() const { return rig ? rig->tof.pinhole : camera; }
};

/// An image of rgb.txt goes with the depth map of depth.txt nearest in time, if each is the
/// other's nearest and they are no further apart than this.
inline constexpr std::int64_t recording_tolerance_ns = 20'000'000;
/// The same of two cameras' frames that associations.txt pairs: their maps count by times of their
/// own.
inline constexpr std::int64_t rig_tolerance_ns = 100'000'000;

/// Another order of a recording's frames, to see what a result owes to the one that was recorded.
struct FrameOrder {
    int skip = 0;         ///< frames left out at the start
    int every = 1;        ///< of the others the first and each so many-th is kept, at least 1
    bool reverse = false; ///< then the last comes first: time runs backwards

    bool operator==(const FrameOrder &) const = default;
};

/// Puts the entries into that order; at least one stays. Times still rise: t becomes
/// first + last - t where they are reversed. The ground truth stays that of the recorded times.
void reorder(Recording &recording, const FrameOrder &order);

/// Why these numbers cannot be fx, fy, cx, cy, width and height of a pinhole camera, all in pixels:
/// a sentence, empty if they can.
std::string camera_problem(const std::array<double, 6> &camera);

/// What camera.txt says.
struct RecordingCamera {
    Intrinsics intrinsics;
    double depth_units_per_metre = 0;
};
Result<RecordingCamera> read_recording_camera(const std::string &folder);

/// Reads the text files of a recording; opens no image. Errors name file and line. `camera` stands
/// in for a camera.txt that is not there, as in the folders that the benchmark itself publishes.
/// `rig`: it is of these two cameras; camera.txt must have the size of the colour camera's images.
Result<Recording> open_recording(const std::string &folder,
                                 const std::optional<RecordingCamera> &camera = std::nullopt,
                                 const std::optional<RigCalibration> &rig = std::nullopt);

/// Reads an entry's depth map into `depth`, which must have the size of tof(), as millimetres:
/// rounded, and 0 where it is further than 65535 mm. Allocates nothing but in the PNG library.
Status read_depth_mm(const Recording &recording, std::size_t entry, ImageView<std::uint16_t> depth);

} // namespace afterglow
