// SPDX-License-Identifier: Apache-2.0
#include "drivers/libcamera/formats.hpp"
#include "drivers/libcamera/helper/helper.hpp"
#include "drivers/libcamera/wire.hpp"

#include <fmt/format.h>

#include <cerrno>
#include <libcamera/camera_manager.h>
#include <libcamera/property_ids.h>
#include <libcamera/stream.h>

namespace afterglow::libcam {
namespace {

using namespace libcamera;

void list_modes(Camera &camera) {
    const std::unique_ptr<CameraConfiguration> configuration =
        camera.generateConfiguration({StreamRole::Viewfinder});
    if (!configuration || configuration->empty())
        return;
    const StreamFormats &formats = configuration->at(0).formats();
    for (const std::uint32_t code : readable_formats()) {
        for (const Size &size : formats.sizes(pixel_format(code))) {
            Report report;
            report.kind = Report::Kind::mode;
            report.fourcc = code;
            report.width = static_cast<std::int32_t>(size.width);
            report.height = static_cast<std::int32_t>(size.height);
            send(helper_socket, report);
        }
    }
}

} // namespace

void list_cameras() {
    CameraManager manager;
    if (const int error = manager.start(); error < 0)
        return say_failed("libcamera does not start", -error);
    for (const std::shared_ptr<Camera> &camera : manager.cameras()) {
        Report report;
        report.kind = Report::Kind::camera;
        report.set_text(
            fmt::format("{}\n{}", camera->id(),
                        camera->properties().get(properties::Model).value_or("camera")));
        send(helper_socket, report);
        list_modes(*camera);
    }
    Report done;
    done.kind = Report::Kind::done;
    send(helper_socket, done);
}

} // namespace afterglow::libcam
