// SPDX-License-Identifier: Apache-2.0
#include "drivers/libcamera/formats.hpp"
#include "drivers/libcamera/helper/helper.hpp"

#include <fmt/format.h>

#include <cerrno>
#include <libcamera/stream.h>

namespace afterglow::libcam {
namespace {

using namespace libcamera;

bool is_as_wished(CameraConfiguration &configuration, const PixelFormat &format, const Size &size) {
    StreamConfiguration &stream = configuration.at(0);
    stream.pixelFormat = format;
    stream.size = size;
    // What was adjusted may be the colour space, which luma does not depend on.
    return configuration.validate() != CameraConfiguration::Invalid && configuration.size() == 1 &&
           stream.pixelFormat == format && stream.size == size;
}

} // namespace

PixelFormat pixel_format(std::uint32_t v4l2_code) {
    return PixelFormat(drm_code(v4l2_code));
}

std::unique_ptr<CameraConfiguration> configuration(Camera &camera, const CaptureRequest &wanted) {
    const Size size(static_cast<unsigned>(wanted.width), static_cast<unsigned>(wanted.height));
    std::unique_ptr<CameraConfiguration> configuration =
        camera.generateConfiguration({StreamRole::Viewfinder});
    std::string offered;
    if (configuration && !configuration->empty()) {
        for (const std::uint32_t code : wanted.formats) {
            if (is_as_wished(*configuration, pixel_format(code), size))
                return configuration;
        }
        for (const PixelFormat &format : configuration->at(0).formats().pixelformats())
            offered += (offered.empty() ? "" : ", ") + format.toString();
    }
    say_failed(fmt::format("the camera '{}' has no usable format of {}x{} (it offers {})",
                           wanted.id, wanted.width, wanted.height,
                           offered.empty() ? "none" : offered),
               EINVAL);
    return nullptr;
}

} // namespace afterglow::libcam
