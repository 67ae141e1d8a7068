// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "tools/testcam/settings.hpp"

#include <cstdint>
#include <fstream>
#include <mutex>
#include <optional>
#include <string>

namespace afterglow::testcam {

/// The illumination under which a map was exposed.
enum class Light { dark, settling, good };

/// The emitter: lit while it is switched on and the camera streams. Its log has a line for each
/// change, and for each map: "TIME on", "TIME off", "TIME map SEQUENCE"; CLOCK_MONOTONIC, ns.
///
/// Any thread.
class Emitter {
public:
    explicit Emitter(const Settings &settings);

    /// On by default, as with real devices.
    void set_on(bool on);
    void set_streaming(bool streaming);
    bool is_lit();
    /// The illumination of the map exposed at `t_ns`; logs that map.
    Light expose(std::int64_t t_ns, std::uint64_t sequence);

private:
    void update();
    void note(std::int64_t t_ns, const std::string &what);

    const std::int64_t wake_ns_;
    const int warmup_maps_;
    std::mutex mutex_;
    bool on_ = true;
    bool streaming_ = false;
    std::optional<std::int64_t> lit_since_ns_;
    int maps_since_lit_ = 0;
    std::ofstream log_;
};

} // namespace afterglow::testcam
