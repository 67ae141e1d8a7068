// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "config/calibration_file.hpp"
#include "core/base/result.hpp"
#include "drivers/files/write_recording.hpp"
#include "drivers/simulated/synthetic/synthetic.hpp"

#include <cerrno>
#include <fstream>
#include <string>

namespace afterglow::testing {

/// Films the synthetic room with the two cameras of the options, as many frames as they say, as a
/// recording.
inline Status record_rig(SyntheticOptions options, const std::string &folder) {
    options.real_time = false;
    const RigCalibration cameras = synthetic_rig(options);
    const Intrinsics &color = cameras.color.pinhole, &tof = cameras.tof.pinhole;
    Result<Rig> rig = open_synthetic(options);
    if (!rig)
        return rig.error();
    Result<RecordingWriter> writer = RecordingWriter::create(folder, color, tof);
    if (!writer)
        return writer.error();
    const std::string file = folder + "/calibration.toml";
    if (!(std::ofstream(file) << calibration_toml(cameras)).flush())
        return Error{file + ": cannot be written", EIO};
    for (const Status &started :
         {rig->color->start(), rig->tof->start(), rig->illuminator->set(true)})
        if (!started)
            return started;
    ColorFrame image{Luma(color.width, color.height)};
    DepthFrame map{DepthMap(tof.width, tof.height)};
    while (rig->color->read(image, {}) == Capture::frame &&
           rig->tof->read(map, {}) == Capture::frame)
        if (Status added = writer->add(image.t_ns, image.luma, map.depth); !added)
            return added;
    return ok();
}

} // namespace afterglow::testing
