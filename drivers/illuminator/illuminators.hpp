// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "core/base/result.hpp"
#include "drivers/source.hpp"

#include <cerrno>
#include <memory>
#include <string>

namespace afterglow {

// Lights that are not part of a camera's own interface. Each set() is one or two system calls.

/// Whether an errno says that the device is not there.
inline bool is_absent(int code) {
    return code == ENOENT || code == ENODEV || code == ENXIO;
}

/// Switches `light` off at the end of its life. A failure is logged, with the light's name and the
/// reason, unless the device is_absent() and the light was not on. Called by
/// the destructor of each driver; not by the estimator thread.
void leave_dark(Illuminator &light) noexcept;

/// A light that is always on: set() only changes lit(), and was_lit() is always true.
std::unique_ptr<Illuminator> open_no_light();

struct LedOptions {
    std::string name; ///< in /sys/class/leds
    int on = 1;       ///< brightness
    int off = 0;
    std::string folder = "/sys/class/leds";
};

/// A LED of the kernel's LED class; dark when it is opened, and opened again for the next set()
/// after one that failed. Errors: ENOENT where there is no such LED, EACCES where its brightness
/// may not be written, ERANGE where it does not reach `on` or `off`.
Result<std::unique_ptr<Illuminator>> open_led(const LedOptions &options);

struct GpioOptions {
    std::string chip; ///< "gpiochip0", or a path
    int line = 0;
    bool active_low = false; ///< lit while the line is low
};

/// A line of a GPIO chip, requested for as long as the object exists; dark from the request on.
/// Uses the kernel's interface (version 2, Linux 5.10), because libgpiod's API differs between
/// Debian releases. Errors: ENOENT, ENOTTY or EINVAL where there is no such chip or line, EBUSY
/// where another program uses it.
Result<std::unique_ptr<Illuminator>> open_gpio(const GpioOptions &options);

} // namespace afterglow
