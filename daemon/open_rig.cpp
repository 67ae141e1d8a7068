// SPDX-License-Identifier: Apache-2.0
#include "daemon/open_rig.hpp"

#include <cassert>

namespace afterglow {

Result<Rig> open_rig(const Config &config) {
    // load_config() has refused everything else: both drivers are one device with three faces.
    assert(config.tof == config.color && config.illuminator == config.color);
    switch (config.color) {
    case Driver::synthetic:
        return open_synthetic(config.synthetic);
    case Driver::replay:
        return open_replay(config.replay);
    }
    return Error{"there is no such driver", 0};
}

} // namespace afterglow
