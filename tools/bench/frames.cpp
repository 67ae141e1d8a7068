// SPDX-License-Identifier: Apache-2.0
#include "tools/bench/frames.hpp"

#include "eval/run.hpp"

#include <cerrno>
#include <chrono>
#include <utility>

namespace afterglow::bench {

Result<Frames> load_frames(const std::string &dataset, int most) {
    FootageArguments arguments;
    arguments.frames = most;
    auto footage = arguments.open(dataset);
    if (!footage)
        return footage.error();
    const Rig &rig = footage->rig;
    for (const Status &started : {rig.color->start(), rig.tof->start(), rig.illuminator->set(true)})
        if (!started)
            return started.error();

    Frames loaded{.name = footage->name, .camera = rig.color->intrinsics(), .frames = {}};
    const auto [width, height] = std::pair(loaded.camera.width, loaded.camera.height);
    for (;;) {
        ColorFrame color{.luma = Luma(width, height)};
        DepthFrame depth{.depth = DepthMap(width, height)};
        const Capture image = rig.color->read(color, std::chrono::seconds(1));
        if (image == Capture::ended)
            break;
        if (image != Capture::frame)
            return Error{dataset + ": " + rig.color->problem(), EIO};
        if (rig.tof->read(depth, std::chrono::seconds(1)) != Capture::frame)
            return Error{dataset + ": " + rig.tof->problem(), EIO};
        loaded.frames.push_back({color.t_ns, std::move(color.luma), std::move(depth.depth)});
    }
    if (loaded.frames.empty())
        return Error{dataset + ": there are no frames", EINVAL};
    return loaded;
}

} // namespace afterglow::bench
