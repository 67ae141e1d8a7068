// SPDX-License-Identifier: Apache-2.0
#include "config/calibration_file.hpp"
#include "core/base/degrees.hpp"
#include "tools/ctl/calibration/rig_figures.hpp"
#include "tools/ctl/calibration/running.hpp"
#include "tools/ctl/calibration/verbs.hpp"
#include "tools/ctl/daemon.hpp"
#include "tools/ctl/json.hpp"

#include <fmt/format.h>

#include <cstddef>

namespace afterglow {
namespace {

Json json_of(const FoundCamera &camera) {
    const auto &[fx, fy, cx, cy, width, height] = camera.model.pinhole;
    const CameraFigures figures = figures_of(camera.model);
    return {{"width", width},
            {"height", height},
            {"model", lens_name(camera.model.lens)},
            {"fx", fx},
            {"fy", fy},
            {"cx", cx},
            {"cy", cy},
            {"distortion", camera.model.distortion},
            {"horizontal_degrees", figures.horizontal_degrees},
            {"vertical_degrees", figures.vertical_degrees},
            {"lens_px", figures.lens_px}};
}

Json json_of(const PartialRig &rig) {
    Json document = Json::object();
    if (rig.color) {
        document["color"] = json_of(*rig.color);
        document["color"]["readout_ms"] = rig.color->readout_s * 1000;
    }
    if (rig.tof) {
        document["tof"] = json_of(*rig.tof);
        document["tof"]["range"] = rig.tof->range_along_ray ? "ray" : "z";
    }
    if (rig.color && rig.tof)
        document["tof"]["delay_ms"] = delay_s(rig) * 1000;
    if (rig.tof_from_color) {
        const auto &[R, T] = *rig.tof_from_color;
        Json rows = Json::array();
        for (int i = 0; i < 3; ++i)
            rows.push_back({R(i, 0), R(i, 1), R(i, 2)});
        document["tof_from_color"] = {
            {"translation_m", {T.x(), T.y(), T.z()}},
            {"rotation", rows},
            {"baseline_mm", T.norm() * 1000},
            {"angle_degrees", rig.tof_from_color->angle() * degrees_per_radian},
            {"outside_percent",
             100 * share_outside(rig.color->model, rig.tof->model, *rig.tof_from_color)}};
    }
    return document;
}

void print_row(const char *label, const std::string &text) {
    fmt::print("{:<16} {}\n", label, text);
}

void print_camera(const char *label, const FoundCamera &camera) {
    const auto &[fx, fy, cx, cy, width, height] = camera.model.pinhole;
    const CameraFigures figures = figures_of(camera.model);
    print_row(label, fmt::format("{} x {}, {:.1f} x {:.1f} degrees", width, height,
                                 figures.horizontal_degrees, figures.vertical_degrees));
    print_row("", fmt::format("fx {:.2f}, fy {:.2f}, cx {:.2f}, cy {:.2f}", fx, fy, cx, cy));
    print_row("", camera.model.lens == Lens::pinhole
                      ? "no lens distortion"
                      : fmt::format("{}; at the corners up to {:.1f} pixels",
                                    lens_name(camera.model.lens), figures.lens_px));
}

void print(const PartialRig &rig) {
    if (rig.color) {
        print_camera("colour camera", *rig.color);
        print_row("", rig.color->readout_s > 0
                          ? fmt::format("read out in {:.4g} ms", rig.color->readout_s * 1000)
                          : "global shutter, or unknown");
    }
    if (rig.tof) {
        print_camera("TOF camera", *rig.tof);
        print_row("", rig.tof->range_along_ray ? "gives distances along the rays"
                                               : "gives depth along the axis");
    }
    if (rig.color && rig.tof)
        print_row("", fmt::format("time stamps {:.4g} ms too early", delay_s(rig) * 1000));
    if (!rig.tof_from_color)
        return;
    const auto &[R, T] = *rig.tof_from_color;
    print_row(
        "TOF from colour",
        fmt::format("{:.1f} mm apart (x {:.1f}, y {:.1f}, z {:.1f}), turned by {:.2f} degrees",
                    T.norm() * 1000, T.x() * 1000, T.y() * 1000, T.z() * 1000,
                    rig.tof_from_color->angle() * degrees_per_radian));
    print_row("", fmt::format(
                      "{:.0f} % of the TOF picture outside the colour picture at 1 m",
                      100 * share_outside(rig.color->model, rig.tof->model, *rig.tof_from_color)));
}

Result<PartialRig> read_or_ask(const RigFiles &files, const std::string &bus) {
    if (!files.paths.empty())
        return read_rig(files);
    const Result<Json> properties = Daemon::properties_on(bus);
    if (!properties)
        return properties.error();
    return running_rig(*properties);
}

} // namespace

Result<int> show_calibration(const RigFiles &files, const Settings &settings) {
    const Result<PartialRig> rig = read_or_ask(files, settings.bus);
    if (!rig)
        return rig.error();
    if (settings.json)
        return print_json(json_of(*rig));
    print(*rig);
    return 0;
}

} // namespace afterglow
