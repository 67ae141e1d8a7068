// SPDX-License-Identifier: Apache-2.0
#include "eval/ablate.hpp"
#include "eval/import.hpp"
#include "eval/live/live.hpp"
#include "eval/protocol.hpp"
#include "eval/rigs.hpp"
#include "eval/run.hpp"
#ifdef AFTERGLOW_REPORT
#include "eval/report/report.hpp"
#endif
#include "tools/command_line/run_program.hpp"

#include <CLI/CLI.hpp>
#include <fmt/format.h>

#include <cstdio>
#include <functional>
#include <memory>
#include <vector>

using namespace afterglow;

namespace {

struct Command {
    CLI::App *app;
    std::function<Status()> check; ///< of what CLI11 could not check
    std::function<Status()> run;
};

/// All commands of the program. What they are told lives as long as they do.
class Commands {
public:
    explicit Commands(CLI::App &app) : app_(app) {
        add_tuned<RunArguments>("run", "Score a recording as fast as it can be read", run);
        add_tuned<LiveArguments>("live",
                                 "Start the daemon, read its frames in real time as any program "
                                 "would, score them",
                                 live);
        add_tuned<AblateArguments>(
            "ablate", "Score recordings with each stage of the estimator switched off in turn",
            ablate);
        add_tuned<ProtocolArguments>(
            "protocol",
            "Score recordings forwards, backwards, with every second frame and with shifted "
            "starts, beside the same with the pose from the true depth",
            protocol);
        add_tuned<RigsArguments>("rigs",
                                 "Score rigs of two different simulated cameras beside one with "
                                 "registered depth",
                                 rigs);
        add_tuned<ParametersArguments>(
            "parameters", "List what --set takes, with values and meaning", list_parameters);
#ifdef AFTERGLOW_REPORT
        add_report("compare", "Every system at about one duty cycle (Tables III, IV)",
                   {.compare = true});
        add_report("tradeoff", "Duty cycle against error, a curve for every system",
                   {.tradeoff = true});
        add_report("runtime", "Times of flow, stages and systems (Tables I, V)", {.runtime = true});
        add_report("ransac", "Effect of RANSAC (Table II)", {.ransac = true});
        add_report("power", "Power of the whole system (Table VI)", {.power = true});
        add_report("infill", "Give back depth that the TOF camera cannot see", {.infill = true});
        add_report("report",
                   "compare, tradeoff, runtime, ransac, power, infill and ablate in one report",
                   Experiments::all());
        add<MergeArguments>("merge", "One report of many jobs' run --json", merge);
#endif
        add<ImportArguments>("import", "Turn a published dataset into a recording", import);
    }

    const Command &chosen() const {
        for (const Command &command : commands_)
            if (*command.app)
                return command;
        throw CLI::RequiredError("a command");
    }

private:
    template <class Arguments>
    Arguments &add(const char *name, const char *description, Status (*run)(const Arguments &),
                   const std::shared_ptr<Arguments> &arguments = std::make_shared<Arguments>()) {
        CLI::App *command = app_.add_subcommand(name, description);
        arguments->add_to(*command);
        commands_.push_back({command, ok, [=] { return run(*arguments); }});
        return *arguments;
    }
    template <class Arguments>
    void add_tuned(const char *name, const char *description, Status (*run)(const Arguments &)) {
        const Arguments &arguments = add<Arguments>(name, description, run);
        commands_.back().check = [&] {
            const auto resolved = arguments.tuning.resolve();
            return resolved ? ok() : Status(resolved.error());
        };
    }
#ifdef AFTERGLOW_REPORT
    void add_report(const char *name, const char *description, const Experiments &experiments) {
        const auto arguments = std::make_shared<ReportArguments>();
        arguments->experiments = experiments;
        add<ReportArguments>(name, description, report, arguments);
    }
#endif

    CLI::App &app_;
    std::vector<Command> commands_;
};

std::string explain_unknown(const CLI::App &app, const std::string &name) {
#ifndef AFTERGLOW_REPORT
    for (const char *left_out :
         {"compare", "tradeoff", "runtime", "ransac", "power", "infill", "report", "merge"})
        if (name == left_out)
            return fmt::format("this build has no command \"{}\": it was configured with "
                               "AFTERGLOW_REPORT=OFF; ./dev eval builds and runs it, or configure "
                               "with -DAFTERGLOW_REPORT=ON (needs OpenCV and dlib)",
                               name);
#endif
    return no_such_command(app, name);
}

} // namespace

/// 0: done; 1: it could not be done; 2: the command line is wrong.
int main(int argc, char **argv) {
    CLI::App app{"Scores afterglow's depth against the truth.", "afterglow-eval"};
    app.require_subcommand(1);
    app.set_version_flag("--version", AFTERGLOW_VERSION);
    const Commands commands(app);
    const auto action = [&]() -> Result<int> {
        const Command &command = commands.chosen();
        if (const Status checked = command.check(); !checked) {
            fmt::print(stderr, "afterglow-eval: {}\n", checked.error().message);
            return exit_usage;
        }
        const Status done = command.run();
        return done ? Result<int>(0) : done.error();
    };
    return run_program(app, argc, argv, action, explain_unknown);
}
