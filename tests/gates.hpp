// SPDX-License-Identifier: Apache-2.0
//
// Estimates for a gate, and gates that are taken through them.
#pragma once

#include "core/gate.hpp"

#include <vector>

namespace afterglow::testing {

inline const Estimate good{.source = FrameSource::estimated};
inline const Estimate bad{.source = FrameSource::none, .wants_measurement = true};

/// An estimate that predicts its error and coverage, percent.
inline Estimate expecting(double mre, double coverage = 100, double fresh_mre = 0) {
    Estimate e{.source = FrameSource::estimated};
    e.expected_mre = static_cast<float>(mre);
    e.independent_mre = e.expected_mre;
    e.fresh_mre = static_cast<float>(fresh_mre);
    e.relative_coverage = static_cast<float>(coverage);
    return e;
}

/// A gate whose first measurement took `latency` images to arrive.
inline Gate measured_gate(const GatePolicy &policy, int latency = 0) {
    Gate gate(policy);
    for (int i = 0; i <= latency; ++i)
        gate.wants_light(bad);
    gate.measured();
    return gate;
}

/// The number of the image, from 1, for which the gate first asks for light; 0: never in `most`.
template <class Estimates>
int first_lit(Gate &gate, int most, Estimates &&estimate) {
    for (int k = 1; k <= most; ++k)
        if (gate.wants_light(estimate(k)))
            return k;
    return 0;
}

/// The images for which a gate asks for light, of `frames`; a measurement arrives with the last of
/// `1 + latency` lit images in a row.
template <class Estimates>
std::vector<bool> lit_images(Gate &gate, int frames, int latency, Estimates &&estimate) {
    std::vector<bool> lit;
    int row = 0;
    for (int k = 0; k < frames; ++k) {
        lit.push_back(gate.wants_light(estimate(k)));
        row = lit.back() ? row + 1 : 0;
        if (row == 1 + latency) {
            gate.measured();
            row = 0;
        }
    }
    return lit;
}

} // namespace afterglow::testing
