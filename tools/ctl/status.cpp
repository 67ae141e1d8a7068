// SPDX-License-Identifier: Apache-2.0
#include "tools/ctl/calibration/running.hpp"
#include "tools/ctl/command.hpp"
#include "tools/ctl/daemon.hpp"
#include "tools/ctl/properties.hpp"
#include "tools/ctl/requests.hpp"
#include "tools/ctl/rights.hpp"

#include <fmt/format.h>

#include <set>
#include <string>
#include <string_view>

namespace afterglow {
namespace {

std::string_view meaning(std::string_view state) {
    if (state == "starting")
        return "starting the cameras";
    if (state == "idle")
        return "idle: nobody reads, cameras and light are off";
    if (state == "color-lost")
        return "the colour camera is lost; no frames until it is back";
    if (state == "tof-lost")
        return "the TOF camera is lost; frames go on without new measurements";
    if (state == "stopped")
        return "the recording is over";
    return state; // "running", and what later versions may add
}

/// What the daemon was told, and what rules now where that is something else.
void print_policy(const Json &p) {
    const std::string mode = text(p, "Mode");
    const std::string effective = text(p, "EffectiveMode");
    fmt::print("  mode      {}{}\n", mode,
               effective == mode ? "" : fmt::format("; {} by request", effective));
    const double target = number(p, "TargetError");
    const double effective_target = number(p, "EffectiveTargetError");
    fmt::print("  target    {:.4g} % error{}", target,
               effective_target == target ? ""
                                          : fmt::format("; {:.4g} % by request", effective_target));
    if (const double age = number(p, "EffectiveMaxAge"); age > 0)
        fmt::print(", at most {:.0f} ms old", age);
    const double budget = number(p, "DutyCycleBudget");
    fmt::print(
        "\n  budget    {}{}\n",
        budget < 100 ? fmt::format("light for {:.4g} % of the frames at most", budget) : "none",
        number(p, "BudgetSpent") != 0 ? "; spent: the light waits, and depth is worse than wanted"
                                      : "");
}

void print_frames(const Json &p) {
    const double frames = number(p, "FramesPublished");
    fmt::print("  frames    {:.0f}", frames);
    if (frames > 0)
        fmt::print(": {:.0f} measured, {:.0f} estimated, {:.0f} without depth",
                   number(p, "FramesMeasured"), number(p, "FramesEstimated"),
                   number(p, "FramesWithoutDepth"));
    const double skipped = number(p, "FramesSkipped");
    fmt::print("{}\n  dropped   {:.0f} damaged, {:.0f} missed\n",
               skipped > 0 ? fmt::format("; {:.0f} images have none, no reader wanted one", skipped)
                           : "",
               number(p, "FramesDamaged"), number(p, "FramesMissed"));
    if (frames == 0)
        return;
    fmt::print("  light     lit {:.1f} %, measured {:.1f} % of the images\n",
               number(p, "DutyCycle"), 100 * number(p, "FramesMeasured") / (frames + skipped));
    fmt::print("  power     {:.2f} W by the power model; CPU {:.2f} s per second, measured\n",
               number(p, "EstimatedPower"), number(p, "CpuLoad"));
    fmt::print("  coverage  {:.1f} % of the last frame\n", number(p, "Coverage"));
    if (const double error = number(p, "ExpectedError"); error >= 0)
        fmt::print("  error     {:.2f} % expected in the last frame\n", error);
    if (const double wake = number(p, "WakeLatency"); wake > 0)
        fmt::print("  wake      {:.0f} ms from asking for light to depth\n", wake * 1e-6);
    if (const double apart = number(p, "PairingErrorP99"); apart > 0)
        fmt::print("  pairing   depth taken within {:.1f} ms of its image\n", apart * 1e-6);
    fmt::print("  latency   {:.1f} ms from image to depth, 99 % within {:.1f} ms\n",
               number(p, "LatencyP50") * 1e-6, number(p, "LatencyP99") * 1e-6);
}

/// Each once: who may not read depth may not see images for the same reason.
std::set<std::string> denials(const Rights &rights) {
    std::set<std::string> reasons;
    for (const auto &reason : {rights.no_depth, rights.no_images, rights.no_control})
        if (reason)
            reasons.insert(*reason);
    return reasons;
}

Result<int> show(const Settings &settings) {
    Result<Daemon> daemon = Daemon::connect(settings.bus);
    if (!daemon)
        return daemon.error();
    const Result<Json> properties = daemon->properties();
    if (!properties)
        return properties.error();
    Result<Json> requests = list_requests(*daemon);
    if (!requests)
        return requests.error();
    const Rights rights = rights_of_caller(*daemon);
    const Json &p = *properties;
    if (settings.json) {
        Json document = scalars(p);
        document["calibration_parts"] = json_of(judged_parts(p));
        document["requests"] = *std::move(requests);
        document["rights"] = {{"read_depth", !rights.no_depth},
                              {"see_images", !rights.no_images},
                              {"control", !rights.no_control}};
        return print_json(document);
    }
    fmt::print("afterglowd {}: {}\n", text(p, "Version"), meaning(text(p, "State")));
    fmt::print("  cameras   colour {}, TOF {}\n", text(p, "ColorCamera"), text(p, "TofCamera"));
    for (const JudgedPart &part : judged_parts(p))
        fmt::print("  rig       {}\n", describe(part));
    print_policy(p);
    fmt::print("  readers   {:.0f}\n", number(p, "OpenStreams"));
    fmt::print("  requests  {}\n", requests->size());
    for (const Json &request : *requests)
        fmt::print("            {}\n", describe_request(request));
    for (const std::string &reason : denials(rights))
        fmt::print("  rights    {}\n", reason);
    print_frames(p);
    return 0;
}

} // namespace

Action declare_status(CLI::App & /*app*/, const Settings &settings) {
    return [&settings] { return show(settings); };
}

} // namespace afterglow
