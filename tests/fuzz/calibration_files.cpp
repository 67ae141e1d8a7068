// SPDX-License-Identifier: Apache-2.0
//
// A file that is said to be the calibration of a camera or of a rig, in any format. What is refused
// is refused with a sentence; what is taken has rays, can be shown, and is written as a file that
// says the same.
#include "config/calibration_file.hpp"
#include "tests/fuzz/memory_file.hpp"
#include "tools/ctl/calibration/rig_figures.hpp"

#include <algorithm>
#include <cmath>

using namespace afterglow;

namespace {

void check_figures(const CameraModel &camera) {
    const CameraFigures figures = figures_of(camera);
    require(figures.horizontal_degrees > 0 && figures.horizontal_degrees < 180,
            "a field of view is one");
    require(figures.vertical_degrees > 0 && figures.vertical_degrees < 180,
            "a field of view is one");
    require(std::isfinite(figures.lens_px), "a lens moves pixels by some");
}

void check_same(const RigCalibration &a, const RigCalibration &b) {
    require(a.color == b.color && a.tof == b.tof, "written cameras are the same");
    require((a.tof_from_color.R - b.tof_from_color.R).norm() < 1e-12 &&
                a.tof_from_color.T == b.tof_from_color.T,
            "a written pose is the same");
    require(std::abs(a.tof_delay_s - b.tof_delay_s) < 1e-12 &&
                std::abs(a.readout_s - b.readout_s) < 1e-12 &&
                a.range_along_ray == b.range_along_ray,
            "written times are the same");
}

} // namespace

extern "C" int LLVMFuzzerTestOneInput(const char *data, std::size_t size) {
    const MemoryFile file({data, size});
    RigFiles files;
    files.paths = {file.path()};
    files.color_size = files.tof_size = "64x48";
    const Result<PartialRig> partial = read_rig(files);
    if (!partial) {
        const std::string &sentence = partial.error().message;
        require(!sentence.empty(), "an error has a sentence");
        require(
            std::none_of(sentence.begin(), sentence.end(),
                         [](char c) { return static_cast<unsigned char>(c) < ' ' && c != '\n'; }),
            "an error is safe to print");
        return 0;
    }
    for (const auto &camera : {partial->color, partial->tof})
        if (camera)
            check_figures(camera->model);
    suspicions(*partial);
    if (const Result<RigCalibration> rig = whole(*partial)) {
        const Result<RigCalibration> again = parse_calibration(calibration_toml(*rig), "again");
        require(bool(again), "a written calibration is accepted");
        check_same(*rig, *again);
    }
    return 0;
}
