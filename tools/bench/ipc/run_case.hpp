// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "tools/bench/ipc/transport.hpp"

#include <vector>

namespace afterglow::bench {

struct CaseResult {
    std::vector<std::int64_t> latencies_ns; ///< of each frame at each reader that got it
    std::size_t missed = 0;                 ///< the others
};

/// Publishes `frames` frames to `readers` other processes, after some that do not count. Errors:
/// what a process said at its end, or that the frames did not arrive.
Result<CaseResult> run_case(const Transport &transport, int readers, int frames,
                            const std::string &folder);

} // namespace afterglow::bench
