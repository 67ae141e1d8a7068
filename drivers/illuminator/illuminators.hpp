// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "core/base/result.hpp"
#include "drivers/source.hpp"

#include <memory>
#include <string>

namespace afterglow {

// Lights that are no part of a camera's own interface. Each set() is a system call or two.

/// A light that cannot be switched: every frame is exposed in it, whatever is asked.
std::unique_ptr<Illuminator> open_no_light();

struct LedOptions {
    std::string name; ///< in /sys/class/leds
    int on = 1;       ///< brightness
    int off = 0;
    std::string folder = "/sys/class/leds";
};

/// A LED of the kernel's LED class. Errors: there is no such LED, its brightness may not be
/// written, or does not reach `on`.
Result<std::unique_ptr<Illuminator>> open_led(const LedOptions &options);

struct GpioOptions {
    std::string chip; ///< "gpiochip0", or a path
    int line = 0;
    bool active_low = false; ///< lit while the line is low
};

/// A line of a GPIO chip, held for as long as the light exists. The kernel's own interface
/// (version 2, Linux 5.10) and no library: that of libgpiod is another in each Debian release.
/// Errors: there is no such chip or line, or somebody else has it.
Result<std::unique_ptr<Illuminator>> open_gpio(const GpioOptions &options);

} // namespace afterglow
