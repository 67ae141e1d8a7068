// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "eval/experiments/results.hpp"
#include "eval/experiments/sequence.hpp"

#include <vector>

namespace afterglow {

/// Section VIII of Noraky & Sze 2019: a TOF camera whose range ends, or which saturates, is given
/// back what it cannot see from an earlier map that has it. Here the earlier map is whole and, ten
/// frames later, the furthest fifth of the measured depths (out of range), or the nearest
/// (saturation), is taken away; so that also what is filled in can be scored, which the paper could
/// not.
struct Infill {
    std::vector<InfillScore> scores; ///< by "paper" and "default", for both reasons
    std::vector<Picture> pictures;   ///< of one trial
};
Infill infill(const Sequence &sequence, int workers, Watch &watch);

/// The work of that for each frame.
double infill_work();

} // namespace afterglow
