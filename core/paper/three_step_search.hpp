// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "core/base/image.hpp"

namespace afterglow {

/// Integer displacement, pixels.
struct Displacement {
    int du = 0;
    int dv = 0;
    bool operator==(const Displacement &) const = default;
};

/// Three-step search (Koga 1981; Noraky & Sze 2019, Section IV-A): where the `block` x `block`
/// pixels around (u, v) of `from` went in `to`, by the least sum of absolute differences. Tries the
/// centre and its eight neighbours `step` pixels away, moves to the best, halves the step, and
/// stops after step 1, so it reaches 2 * step - 1 pixels each way. Of equals the first tried wins,
/// the centre before all. Candidates whose block leaves the image are passed over.
///
/// `block` is odd, and the block around (u, v) lies inside `from`; both images have one size.
/// Real-time safe.
Displacement three_step_search(LumaView from, LumaView to, int u, int v, int block, int step);

} // namespace afterglow
