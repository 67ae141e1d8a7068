// SPDX-License-Identifier: Apache-2.0
#include "tools/calibrate/camera_feed.hpp"

#include "daemon/open_rig.hpp"

#include <chrono>
#include <utility>

namespace afterglow {
namespace {

constexpr int most_waits = 100; ///< of wait_for each, until a camera is taken to be dead
constexpr auto wait_for = std::chrono::milliseconds(100);
constexpr int most_maps = 100; ///< that are taken at a time

} // namespace

CameraFeed::CameraFeed(Rig rig) : rig_(std::move(rig)) {
    const Intrinsics &color = rig_.color->intrinsics(), &tof = rig_.tof->intrinsics();
    color_.luma = Luma(color.width, color.height);
    tof_.depth = DepthMap(tof.width, tof.height);
}

Result<CameraFeed> CameraFeed::open(const Config &config) {
    Result<Rig> rig = open_rig(config);
    if (!rig)
        return rig.error();
    CameraFeed feed(*std::move(rig));
    Status done = feed.rig_.color->start();
    if (done)
        done = feed.rig_.tof->start();
    if (done)
        done = feed.rig_.illuminator->set(true);
    return done ? Result<CameraFeed>(std::move(feed)) : Result<CameraFeed>(done.error());
}

CameraFeed::~CameraFeed() {
    if (!rig_.illuminator)
        return; // moved from
    // Its destructor tries again, and logs what fails.
    [[maybe_unused]] const Status dark = rig_.illuminator->set(false);
    rig_.tof->stop();
    rig_.color->stop();
}

Status CameraFeed::take_maps() {
    for (int i = 0; i < most_maps; ++i) {
        switch (rig_.tof->read(tof_, std::chrono::nanoseconds(0))) {
        case Capture::frame:
            has_tof_ = true;
            break;
        case Capture::lost:
            return Error{"the TOF camera: " + rig_.tof->problem()};
        case Capture::damaged:
            break;
        case Capture::none:
        case Capture::ended:
            return ok();
        }
    }
    return ok();
}

Result<bool> CameraFeed::next() {
    for (int i = 0; i < most_waits; ++i) {
        const Capture capture = rig_.color->read(color_, wait_for);
        if (Status taken = take_maps(); !taken)
            return taken.error();
        if (capture == Capture::frame)
            return true;
        if (capture == Capture::ended)
            return false;
        if (capture == Capture::lost)
            return Error{"the colour camera: " + rig_.color->problem()};
    }
    return Error{"the colour camera gives no images"};
}

} // namespace afterglow
