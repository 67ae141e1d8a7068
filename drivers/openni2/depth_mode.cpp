// SPDX-License-Identifier: Apache-2.0
#include "drivers/openni2/depth_mode.hpp"

#include "drivers/frame_rate.hpp"

#include <fmt/format.h>

namespace afterglow::openni2 {
namespace {

bool is_better(const openni::VideoMode &a, const openni::VideoMode &b, double fps) {
    const bool a_will_do = is_as_fast(a.getFps(), fps);
    const bool b_will_do = is_as_fast(b.getFps(), fps);
    if (a_will_do != b_will_do)
        return a_will_do;
    return a_will_do ? a.getFps() < b.getFps() : a.getFps() > b.getFps();
}

} // namespace

bool is_depth(const openni::VideoMode &mode) {
    return mode.getPixelFormat() == openni::PIXEL_FORMAT_DEPTH_1_MM ||
           mode.getPixelFormat() == openni::PIXEL_FORMAT_DEPTH_100_UM;
}

int units_per_mm(const openni::VideoMode &mode) {
    return mode.getPixelFormat() == openni::PIXEL_FORMAT_DEPTH_100_UM ? 10 : 1;
}

std::string describe(const openni::VideoMode &mode) {
    return fmt::format("{}x{} at {}, {}", mode.getResolutionX(), mode.getResolutionY(),
                       mode.getFps(), units_per_mm(mode) == 1 ? "1 mm" : "0.1 mm");
}

std::optional<openni::VideoMode> choose_mode(const openni::Array<openni::VideoMode> &modes,
                                             const OpenNi2Options &options) {
    std::optional<openni::VideoMode> best;
    for (int i = 0; i < modes.getSize(); ++i) {
        const openni::VideoMode &mode = modes[i];
        if (is_depth(mode) && mode.getResolutionX() == options.camera.width &&
            mode.getResolutionY() == options.camera.height &&
            (!best || is_better(mode, *best, options.fps)))
            best = mode;
    }
    return best;
}

} // namespace afterglow::openni2
