// SPDX-License-Identifier: Apache-2.0
#include "tools/testcam/settings.hpp"

#include <cstdlib>

namespace afterglow::testcam {
namespace {

std::string text(const char *name) {
    const char *value = std::getenv((std::string("AFTERGLOW_TESTCAM_") + name).c_str());
    return value ? value : "";
}

/// What is no number is the default.
double number(const char *name, double usual) {
    const std::string value = text(name);
    char *end = nullptr;
    const double parsed = std::strtod(value.c_str(), &end);
    return !value.empty() && *end == '\0' ? parsed : usual;
}

} // namespace

Settings settings_from_environment() {
    Settings settings;
    settings.recording = text("RECORDING");
    settings.speed = number("SPEED", 1);
    if (!(settings.speed > 0))
        settings.speed = 1;
    settings.wake_ns = static_cast<std::int64_t>(number("WAKE_MS", 0) * 1e6);
    settings.warmup_maps = static_cast<int>(number("SETTLING_MAPS", 0));
    settings.drift_ppm = number("DRIFT_PPM", 0);
    settings.plugged = number("PLUGGED", 1) != 0;
    settings.log = text("LOG");
    settings.commands = text("COMMANDS");
    return settings;
}

} // namespace afterglow::testcam
