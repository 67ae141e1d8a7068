// SPDX-License-Identifier: Apache-2.0
#include "config/calibration_file.hpp"
#include "core/base/degrees.hpp"
#include "core/base/write_file.hpp"
#include "tools/calibrate/assessment.hpp"
#include "tools/calibrate/captures.hpp"
#include "tools/calibrate/command.hpp"
#include "tools/calibrate/depth_fit.hpp"
#include "tools/calibrate/observe.hpp"
#include "tools/calibrate/report_pictures.hpp"

#include <fmt/format.h>

#include <cstdio>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

namespace afterglow {
namespace {

struct SolveArguments {
    std::string captures;
    std::string output;
    std::string report;
    std::string board;
    std::optional<Lens> lens, tof_lens;
    std::vector<double> tof_intrinsics;
};

/// What was found within the noise of the measurement is not there.
constexpr double least_readout_s = 0.0005;

void print_camera(const char *name, const CameraModel &camera, const LensModel &model,
                  double noise_px, const Coverage &coverage) {
    const Intrinsics &p = camera.pinhole;
    fmt::print("{} camera, {}x{}: {}, focal length {:.2f} x {:.2f}, principal point {:.2f}, {:.2f}",
               name, p.width, p.height, to_text(model), p.fx, p.fy, p.cx, p.cy);
    if (noise_px > 0)
        fmt::print("; residual {:.3f} px; seen in {:.0f} % of the view:\n{}", noise_px,
                   100 * coverage.share(), coverage.text("    "));
    else
        fmt::print("\n");
}

void print_fit(const RigFit &fit, std::span<const BoardView> views,
               const std::optional<TimingFit> &timing) {
    print_camera("Colour", fit.rig.color, fit.color_model, fit.color_noise_px,
                 color_coverage(fit, views));
    print_camera("TOF", fit.rig.tof, fit.tof_model, fit.tof_noise_px, tof_coverage(fit, views));
    const Eigen::Vector3d mm = 1000 * fit.rig.tof_from_color.T;
    fmt::print("TOF from colour: translation {:.1f}, {:.1f}, {:.1f} mm (to {:.1f}), turned by "
               "{:.2f} degrees (to {:.2f})\n",
               mm.x(), mm.y(), mm.z(), 1000 * fit.sigma.translation_m,
               degrees_per_radian * fit.rig.tof_from_color.angle(),
               degrees_per_radian * fit.sigma.rotation_rad);
    if (fit.depth_scale)
        fmt::print("Depth: along {}, {:.1f} % of the board's distance, noise {:.1f} mm\n",
                   fit.rig.range_along_ray ? "the ray" : "Z", 100 * *fit.depth_scale,
                   1000 * fit.depth_noise_m);
    if (timing)
        fmt::print("Delay of depth stamps: {:.2f} ms (to {:.2f}); read-out time {:.2f} ms (to "
                   "{:.2f}); from {} images and {} depth maps, the board moving with {:.0f} "
                   "pixels a second\n",
                   1000 * timing->tof_delay_s, 1000 * timing->tof_delay_sigma_s,
                   1000 * timing->readout_s, 1000 * timing->readout_sigma_s, timing->images,
                   timing->maps, timing->speed_px_s);
}

Result<RigWishes> wishes_of(const SolveArguments &arguments, const Intrinsics &tof_size) {
    RigWishes wishes{arguments.lens, arguments.tof_lens, {}};
    const std::vector<double> &given = arguments.tof_intrinsics;
    if (given.empty())
        return wishes;
    if (given.size() != 4 && given.size() != 8 && given.size() != 9 && given.size() != 12)
        return Error{"--tof-intrinsics: fx,fy,cx,cy are expected, and then 4, 5 or 8 coefficients "
                     "of Brown and Conrady if the lens has them"};
    CameraModel camera{{given[0], given[1], given[2], given[3], tof_size.width, tof_size.height},
                       given.size() > 4 ? Lens::brown_conrady : Lens::pinhole};
    std::copy(given.begin() + 4, given.end(), camera.distortion.begin());
    wishes.tof_camera = camera;
    return wishes;
}

Result<int> solve(const SolveArguments &arguments) {
    Result<Captures> captures = read_captures(arguments.captures);
    if (!captures)
        return captures.error();
    if (!arguments.board.empty()) {
        const Result<Board> board = parse_board(arguments.board);
        if (!board)
            return board.error();
        captures->board = *board;
    }
    const Board &board = captures->board;
    const Result<Observations> seen =
        observe(*captures, [](const std::string &line) { fmt::print("{}\n", line); });
    if (!seen)
        return seen.error();
    const Result<RigWishes> wishes = wishes_of(arguments, seen->tof_size);
    if (!wishes)
        return wishes.error();
    const bool by_depth = !seen->has_amplitude || wishes->tof_camera;
    Result<RigFit> fit = (by_depth ? fit_rig_by_depth : fit_rig)(
        board, seen->stills, seen->color_size, seen->tof_size, *wishes);
    if (!fit)
        return fit.error();
    std::optional<TimingFit> timing;
    if (!captures->moving_color.empty()) {
        const Result<TimingFit> found = fit_timing(board, seen->images, seen->maps, fit->rig);
        if (!found)
            return found.error();
        timing = *found;
        fit->rig.tof_delay_s = timing->tof_delay_s;
        // Images that are read in no time, or from the bottom up, have none.
        if (timing->readout_s > std::max(least_readout_s, 3 * timing->readout_sigma_s))
            fit->rig.readout_s = timing->readout_s;
    }
    print_fit(*fit, seen->stills, timing);
    const Assessment assessment = assess(*fit, board, seen->stills, timing);
    fmt::print("Verdict: {}\n", to_text(assessment.verdict));
    for (const std::string &reason : assessment.reasons)
        fmt::print("  - {}\n", reason);
    const bool is_usable = assessment.verdict != Verdict::not_usable;
    if (is_usable) {
        if (Status written = write_file(arguments.output, calibration_toml(fit->rig)); !written)
            return written.error();
        fmt::print("Written: {}. The daemon reads it by rig.calibration = \"{}\"\n",
                   arguments.output, arguments.output);
    }
    if (Status written =
            write_report_pictures(arguments.report, *captures, board, seen->stills, *fit);
        !written)
        return written.error();
    fmt::print("Pictures: {}/color.png, {}depth_on_color.png\n", arguments.report,
               fit->tof_noise_px > 0 ? "tof.png, " : "");
    if (!is_usable)
        return Error{fmt::format("{} was not written: see the verdict", arguments.output)};
    return 0;
}

} // namespace

CalibrateAction declare_solve(CLI::App &app) {
    const auto arguments = std::make_shared<SolveArguments>();
    const std::map<std::string, Lens> lenses = {{"brown-conrady", Lens::brown_conrady},
                                                {"kannala-brandt", Lens::kannala_brandt}};
    app.add_option("CAPTURES", arguments->captures, "the folder that capture has written")
        ->required();
    app.add_option("-o,--output", arguments->output, "the rig's calibration, TOML")
        ->required()
        ->type_name("FILE");
    app.add_option("--report", arguments->report,
                   "where pictures of coverage and residuals go; CAPTURES/report if not given")
        ->type_name("FOLDER");
    app.add_option("--board", arguments->board, "the board, if it is another than was captured")
        ->type_name("BOARD");
    app.add_option_function<std::string>(
           "--lens",
           [arguments, lenses](const std::string &name) { arguments->lens = lenses.at(name); },
           "the colour camera's lens; chosen by the residuals if not given")
        ->check(CLI::IsMember({"brown-conrady", "kannala-brandt"}))
        ->type_name("LENS");
    auto *tof_lens = app.add_option_function<std::string>(
                            "--tof-lens",
                            [arguments, lenses](const std::string &name) {
                                arguments->tof_lens = lenses.at(name);
                            },
                            "the same of the TOF camera")
                         ->check(CLI::IsMember({"brown-conrady", "kannala-brandt"}))
                         ->type_name("LENS");
    app.add_option("--tof-intrinsics", arguments->tof_intrinsics,
                   "fx,fy,cx,cy of a TOF camera that is known, and the coefficients of its lens; "
                   "its place is then found by depth alone")
        ->delimiter(',')
        ->expected(1, 12)
        ->allow_extra_args(false)
        ->excludes(tof_lens)
        ->type_name("NUMBERS");
    return [arguments] {
        if (arguments->report.empty())
            arguments->report = arguments->captures + "/report";
        return solve(*arguments);
    };
}

} // namespace afterglow
