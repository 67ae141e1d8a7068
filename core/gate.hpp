// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "core/estimate.hpp"

#include <optional>
#include <string_view>

namespace afterglow {

/// Who decides when the TOF camera is lit.
enum class GateMode : std::uint8_t {
    automatic = 0, ///< the estimator, when its map would not be good enough
    always_on = 1, ///< every frame is measured
    interval = 2,  ///< every `interval_frames`th frame is measured (Noraky 2017)
    off = 3,       ///< the illuminator stays dark, whatever that costs
};

/// "auto", "always-on", "interval" or "off": the names in configuration and on D-Bus.
std::string_view to_string(GateMode mode);
std::optional<GateMode> gate_mode_from_string(std::string_view name);

struct GatePolicy {
    GateMode mode = GateMode::automatic;
    int interval_frames = 10; ///< for GateMode::interval; 1 measures every frame
};

/// Decides for each image whether the illuminator should be lit. Real-time safe.
class Gate {
public:
    explicit Gate(const GatePolicy &policy) : policy_(policy) {}

    void set_mode(GateMode mode) { policy_.mode = mode; }
    GateMode mode() const { return policy_.mode; }

    /// Called once for each image, with its estimate. Once it has asked for light it goes on
    /// asking until measured() is called, so that a TOF camera slow to wake is waited for.
    bool wants_light(const Estimate &estimate);
    /// A measurement for the current image has arrived.
    void measured();
    /// After measured(): whether the light should stay on until the next image is asked about.
    bool keeps_light() const { return policy_.mode == GateMode::always_on; }

private:
    GatePolicy policy_;
    int frames_since_measurement_ = -1; ///< -1: never measured
    bool waiting_ = false;
};

} // namespace afterglow
