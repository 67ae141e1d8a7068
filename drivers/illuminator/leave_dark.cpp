// SPDX-License-Identifier: Apache-2.0
#include "core/base/log.hpp"
#include "drivers/illuminator/illuminators.hpp"

#include <exception>

namespace afterglow {

void leave_dark(Illuminator &light) noexcept {
    try {
        const bool was_lit = light.lit();
        const Status dark = light.set(false);
        if (dark)
            return;
        if (was_lit || !is_absent(dark.error().code))
            log(Priority::error, "the illuminator may still be lit: " + dark.error().message);
    } catch (const std::exception &error) {
        log(Priority::error, error.what());
    }
}

} // namespace afterglow
