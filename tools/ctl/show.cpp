// SPDX-License-Identifier: Apache-2.0
#include "core/base/printable.hpp"
#include "tools/ctl/commands.hpp"
#include "tools/ctl/daemon_proxy.hpp"

#include <fmt/format.h>

#include <cctype>
#include <nlohmann/json.hpp>
#include <string_view>

namespace afterglow {
namespace {

std::string text(const Properties &properties, const char *name) {
    const auto property = properties.find(name);
    const auto *value =
        property == properties.end() ? nullptr : std::get_if<std::string>(&property->second);
    return value ? printable(*value) : "unknown";
}

/// 0 where an older daemon has no such number.
double number(const Properties &properties, const char *name) {
    const auto property = properties.find(name);
    if (property == properties.end())
        return 0;
    if (const auto *count = std::get_if<std::uint64_t>(&property->second))
        return static_cast<double>(*count);
    const auto *real = std::get_if<double>(&property->second);
    return real ? *real : 0;
}

std::string_view meaning(std::string_view state) {
    if (state == "starting")
        return "starting the cameras";
    if (state == "running")
        return "running";
    if (state == "idle")
        return "idle: nobody reads, cameras and light are off";
    if (state == "color-lost")
        return "the colour camera is lost; no frames until it is back";
    if (state == "tof-lost")
        return "the TOF camera is lost; frames go on without new measurements";
    if (state == "stopped")
        return "the recording is over";
    return state;
}

/// FramesPublished -> frames_published
std::string json_key(std::string_view property) {
    std::string key;
    for (const char letter : property) {
        if (std::isupper(static_cast<unsigned char>(letter)) && !key.empty())
            key += '_';
        key += static_cast<char>(std::tolower(static_cast<unsigned char>(letter)));
    }
    return key;
}

/// The unit of a property in org.afterglow.Depth1.xml; "" for counts and names.
std::string_view unit(std::string_view property) {
    if (property == "DutyCycle" || property == "Coverage" || property == "ExpectedError")
        return " %";
    if (property == "EstimatedPower")
        return " W";
    if (property == "CpuLoad")
        return " s/s (measured)";
    const bool is_time = property.starts_with("Latency") || property == "WakeLatency" ||
                         property.starts_with("PairingError");
    return is_time ? " ns" : "";
}

std::string to_text(const Property &property) {
    if (const auto *value = std::get_if<std::string>(&property))
        return printable(*value);
    if (const auto *count = std::get_if<std::uint64_t>(&property))
        return fmt::format("{}", *count);
    return fmt::format("{:.6g}", *std::get_if<double>(&property));
}

} // namespace

Status show_status(const std::string &bus) {
    const Result<Properties> read = daemon_properties(bus);
    if (!read)
        return read.error();
    const Properties &p = *read;
    fmt::print("afterglowd {}: {}\n", text(p, "Version"), meaning(text(p, "State")));
    fmt::print("  mode      {}\n", text(p, "Mode"));
    fmt::print("  readers   {:.0f}\n", number(p, "OpenStreams"));
    const double frames = number(p, "FramesPublished");
    fmt::print("  frames    {:.0f}", frames);
    if (frames > 0)
        fmt::print(": {:.0f} measured, {:.0f} estimated, {:.0f} without depth",
                   number(p, "FramesMeasured"), number(p, "FramesEstimated"),
                   number(p, "FramesWithoutDepth"));
    fmt::print("\n  dropped   {:.0f} damaged, {:.0f} missed\n", number(p, "FramesDamaged"),
               number(p, "FramesMissed"));
    if (frames == 0)
        return ok();
    fmt::print("  light     lit {:.1f} %, measured {:.1f} % of the frames\n",
               number(p, "DutyCycle"), 100 * number(p, "FramesMeasured") / frames);
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
    return ok();
}

Status show_statistics(const std::string &bus, bool json) {
    const Result<Properties> properties = daemon_properties(bus);
    if (!properties)
        return properties.error();
    nlohmann::ordered_json object = nlohmann::ordered_json::object();
    for (const auto &[name, value] : *properties) {
        if (json)
            std::visit([&, &name = name](const auto &content) { object[json_key(name)] = content; },
                       value);
        else
            fmt::print("{:<20} {}{}\n", name, to_text(value), unit(name));
    }
    if (json) // bytes of a version that are not UTF-8 are replaced
        fmt::print("{}\n", object.dump(2, ' ', false, nlohmann::json::error_handler_t::replace));
    return ok();
}

Status change_mode(const std::string &bus, const std::string &name) {
    if (!name.empty())
        return set_daemon_mode(bus, name);
    const Result<Properties> properties = daemon_properties(bus);
    if (!properties)
        return properties.error();
    fmt::print("{}\n", text(*properties, "Mode"));
    return ok();
}

} // namespace afterglow
