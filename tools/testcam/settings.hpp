// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <string>

namespace afterglow::testcam {

/// The test camera's settings, from environment variables: OpenNI2 has no other way to configure a
/// driver.
struct Settings {
    std::string recording;    ///< AFTERGLOW_TESTCAM_RECORDING: a folder; "" = the synthetic room
    double speed = 1;         ///< AFTERGLOW_TESTCAM_SPEED: of the recorded pace
    std::int64_t wake_ns = 0; ///< AFTERGLOW_TESTCAM_WAKE_MS: from emitter on to the first map
    int warmup_maps = 0;      ///< AFTERGLOW_TESTCAM_SETTLING_MAPS: spoilt ones after that
    double drift_ppm = 0;     ///< AFTERGLOW_TESTCAM_DRIFT_PPM: how much too fast its clock is
    bool plugged = true;      ///< AFTERGLOW_TESTCAM_PLUGGED: 0 = not before it is told so
    std::string log;          ///< AFTERGLOW_TESTCAM_LOG: a file to which it adds lines
    std::string commands;     ///< AFTERGLOW_TESTCAM_COMMANDS: a FIFO it reads lines from
};
Settings settings_from_environment();

} // namespace afterglow::testcam
