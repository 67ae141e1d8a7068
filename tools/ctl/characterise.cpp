// SPDX-License-Identifier: Apache-2.0
#include "tools/characterise/characterise.hpp"

#include "core/base/write_file.hpp"
#include "daemon/open_rig.hpp"
#include "tools/characterise/report.hpp"
#include "tools/command_line/run_program.hpp"
#include "tools/ctl/command.hpp"
#include "tools/ctl/daemon.hpp"
#include "tools/ctl/json.hpp"

#include <fmt/format.h>

#include <atomic>
#include <csignal>
#include <memory>
#include <utility>

namespace afterglow {
namespace {

struct Arguments {
    std::string config = AFTERGLOW_CONFIG_FILE;
    std::string recording;
    std::string output;
    double seconds = 30;
};

std::atomic<bool> stop = false;
static_assert(std::atomic<bool>::is_always_lock_free);

/// A person who stops the program must not leave the light on.
void stop_on_signals() {
    struct sigaction action = {};
    action.sa_handler = [](int) { stop = true; };
    for (const int signal : {SIGINT, SIGTERM, SIGHUP})
        ::sigaction(signal, &action, nullptr);
}

Result<Rig> open(const Arguments &arguments, const Config &config) {
    if (arguments.recording.empty())
        return open_rig(config);
    return open_replay({.path = arguments.recording, .real_time = false});
}

Json json_of(const Characteristics &found) {
    Json bins = Json::array();
    for (const DepthBin &bin : found.bins)
        bins.push_back({{"z_m", bin.z_m}, {"sigma_m", bin.sigma_m}, {"places", bin.pixels}});
    Json warm_up = nullptr;
    if (found.warm_up)
        warm_up = {{"cycles", found.warm_up->cycles},
                   {"unsettled_maps", found.warm_up->unsettled_maps},
                   {"settled_ms", found.warm_up->settled_ms}};
    return {{"maps", found.maps},
            {"noise",
             {{"floor_m", found.fit.noise.floor_m},
              {"linear", found.fit.noise.linear},
              {"quadratic_per_m", found.fit.noise.quadratic_per_m},
              {"misfit", found.fit.misfit},
              {"scaled", found.fit.scaled}}},
            {"bins", bins},
            {"shared_noise", found.shared_noise},
            {"edges",
             {{"crossings", found.edges.crossings},
              {"flying", found.edges.flying},
              {"misplaced_px", found.edges.misplaced_px}}},
            {"warm_up", warm_up}};
}

Result<int> run(const Settings &settings, const Arguments &arguments) {
    const bool is_recorded = !arguments.recording.empty();
    if (!is_recorded && Daemon::is_running(settings.bus))
        return Error{fmt::format("afterglowd runs on {} and has the cameras; stop it first, as by "
                                 "`systemctl stop afterglowd`",
                                 describe_bus(settings.bus)),
                     EBUSY};
    // Looked at before the work, so that it is not in vain.
    if (std::error_code ignored;
        !arguments.output.empty() && std::filesystem::exists(arguments.output, ignored))
        return Error{arguments.output + " exists already; give the name of a new file", EEXIST};
    const Result<Config> config =
        is_recorded ? Result<Config>(Config{}) : load_config(arguments.config);
    if (!config)
        return config.error();
    Result<Rig> rig = open(arguments, *config);
    if (!rig)
        return rig.error();
    const bool switches_light = !is_recorded && config->illuminator.driver != LightDriver::none &&
                                config->illuminator.driver != LightDriver::replay;
    stop_on_signals();
    fmt::print(stderr,
               "Looking for {:g} s of images. Nothing may move, neither the camera nor "
               "what it sees.\n",
               arguments.seconds);
    const Result<Characteristics> found =
        characterise(*rig,
                     {.seconds = arguments.seconds,
                      .cycles = switches_light ? CharacteriseOptions{}.cycles : 0,
                      .noise = config->estimator.keyframe.surface.noise},
                     stop);
    if (!found)
        return found.error();
    const std::string text = report(*found, *config);
    // Whether it can be written or not, the result is printed.
    if (settings.json)
        static_cast<void>(print_json(json_of(*found)));
    else
        fmt::print("{}", text);
    if (!arguments.output.empty())
        if (const Status written = write_new_file(arguments.output, text); !written)
            return written.error();
    return 0;
}

} // namespace

Action declare_characterise(CLI::App &app, const Settings &settings) {
    const auto arguments = std::make_shared<Arguments>();
    auto *config =
        app.add_option("--config", arguments->config, "configuration file that names the cameras")
            ->type_name("FILE")
            ->capture_default_str();
    app.add_option("--recording", arguments->recording,
                   "a still recording in TUM layout instead of cameras")
        ->type_name("FOLDER")
        ->excludes(config);
    app.add_option("--seconds", arguments->seconds, "how long to look")
        ->check(number_between(1, 3600))
        ->capture_default_str();
    app.add_option("-o,--output", arguments->output,
                   "write it to a new file, too; as FILE.d/NAME.toml it overrides FILE")
        ->type_name("FILE");
    return [&settings, arguments] { return run(settings, *arguments); };
}

} // namespace afterglow
