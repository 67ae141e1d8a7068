// SPDX-License-Identifier: Apache-2.0
#include "eval/scoring/recorded_rig_depth.hpp"

#include "drivers/files/image_file.hpp"

#include <algorithm>

namespace afterglow {
namespace {

KeyframeOptions as_calibrated() {
    KeyframeOptions options;
    options.correct_calibration = false;
    return options;
}

} // namespace

RecordedRigDepth::RecordedRigDepth(const RigGeometry &geometry)
    : pool_(1), pipeline_(as_calibrated(), geometry, pool_),
      luma_(geometry.rig.color.pinhole.width, geometry.rig.color.pinhole.height),
      map_(geometry.rig.tof.pinhole.width, geometry.rig.tof.pinhole.height) {}

Result<DepthMap> RecordedRigDepth::at(const Recording &recording, std::size_t entry) {
    const Recording::Entry &files = recording.entries[entry];
    if (Status read = read_luma(files.color_path, luma_); !read)
        return read.error();
    if (Status read = read_depth_mm(recording, entry, map_); !read)
        return read.error();
    pipeline_.restart();
    pipeline_.track(luma_, files.t_color_ns);
    const DepthView seen = pipeline_.measure(map_).depth;
    DepthMap depth(seen.width(), seen.height());
    copy_pixels(seen, depth.view());
    return depth;
}

} // namespace afterglow
