// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "ipc/bus/situation.hpp"

#include <cstdint>
#include <list>
#include <string>
#include <string_view>

namespace afterglow {

/// What a client wants for as long as it holds a descriptor.
struct Wish {
    enum class Kind { accuracy, mode } kind = Kind::accuracy;
    double max_relative_error = 0;       ///< percent; 0: none. Of Kind::accuracy, as is max_age_ms
    std::uint32_t max_age_ms = 0;        ///< 0: none
    GateMode mode = GateMode::automatic; ///< of Kind::mode
    std::string reason{};
};

/// The policy of which the strictest of all wishes rules: off before always-on before interval
/// before auto; in auto the least error and the least age. `own` is the daemon's policy and takes
/// part; its budget bounds every mode.
GatePolicy strictest(GatePolicy own, const std::list<const Wish *> &wishes);

/// What keeps a wish from being granted.
enum class Obstacle {
    none,
    overruled, ///< a stricter mode rules
    dark,      ///< mode off rules
    asleep,    ///< nobody reads
    color_lost,
    tof_lost,
    budget,    ///< the duty-cycle budget is spent
    interval,  ///< mode interval rules and does not meet it
    precision, ///< measurements themselves are not that good
    unhelpful, ///< the gate does not expect a measurement to help
};

/// A sentence; "" for none.
std::string_view to_string(Obstacle obstacle);

/// Why a wish is not granted in this situation, by the newest frame.
Obstacle obstacle_of(const Wish &wish, const Situation &situation);

} // namespace afterglow
