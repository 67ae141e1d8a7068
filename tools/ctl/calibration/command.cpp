// SPDX-License-Identifier: Apache-2.0
#include "tools/ctl/command.hpp"

#include "tools/ctl/calibration/rig_files.hpp"
#include "tools/ctl/calibration/verbs.hpp"

#include <map>
#include <memory>
#include <regex>
#include <string>

namespace afterglow {
namespace {

std::string problem_of_size(const std::string &text) {
    static const std::regex size("[1-9][0-9]{0,5}x[1-9][0-9]{0,5}");
    return std::regex_match(text, size) ? "" : text + " is not WIDTHxHEIGHT, as 640x480";
}

/// What all verbs have. Without files all other options are refused.
std::shared_ptr<RigFiles> declare_files(CLI::App &app, bool required) {
    auto files = std::make_shared<RigFiles>();
    CLI::Option *paths =
        app.add_option("FILE", files->paths,
                       required ? "of OpenCV, ROS, Kalibr or afterglow: cameras, and where they are"
                                : "such files; if not given, what the running afterglowd uses");
    paths->type_name("")->required(required);
    app.add_option("--color", files->color, "the colour camera: its name or its file")
        ->type_name("NAME");
    app.add_option("--tof", files->tof, "the TOF camera: its name or its file")->type_name("NAME");
    app.add_option("--color-size", files->color_size, "of its pictures, if no file tells")
        ->type_name("WxH")
        ->check(problem_of_size);
    app.add_option("--tof-size", files->tof_size, "of its depth maps, if no file tells")
        ->type_name("WxH")
        ->check(problem_of_size);
    app.add_flag("--fisheye", files->hints.fisheye,
                 "OpenCV's coefficients are of its fisheye model");
    static const std::map<std::string, double> units = {{"m", 1}, {"cm", 0.01}, {"mm", 0.001}};
    app.add_option_function<std::string>(
           "--translation-unit",
           [files](const std::string &unit) { files->hints.metres_per_unit = units.at(unit); },
           "of OpenCV's T; metres if not given")
        ->check(CLI::IsMember({"m", "cm", "mm"}))
        ->type_name("UNIT");
    app.add_flag("--invert", files->invert,
                 "R and T take points of the TOF camera to the colour one");
    for (CLI::Option *option : app.get_options())
        if (option != paths && option != app.get_help_ptr())
            option->needs(paths);
    return files;
}

template <auto verb, bool files_required>
Action declare_verb(CLI::App &app, const Settings &settings) {
    return
        [&settings, files = declare_files(app, files_required)] { return verb(*files, settings); };
}

Action declare_convert(CLI::App &app, const Settings &settings) {
    const auto files = declare_files(app, true);
    const auto path = std::make_shared<std::string>();
    app.add_option("-o,--output", *path, "a new file; stdout if not given")->type_name("FILE");
    return [&settings, files, path] { return convert_calibration(*files, *path, settings); };
}

} // namespace

Action declare_calibration(CLI::App &app, const Settings &settings) {
    static constexpr Command commands[] = {
        {"show", "both cameras and where they are", declare_verb<show_calibration, false>},
        {"check", "what is suspicious in it", declare_verb<check_calibration, false>},
        {"convert", "make the file that the daemon reads", declare_convert},
    };
    return declare_commands(app, commands, settings);
}

} // namespace afterglow
