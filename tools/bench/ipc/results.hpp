// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "tools/bench/ipc/run_case.hpp"

#include <string>
#include <string_view>
#include <vector>

namespace afterglow::bench {

/// All rounds of a transport with so many readers.
struct Measured {
    std::string_view transport;
    int readers = 0;
    CaseResult result;
};

/// A table for persons.
std::string table(std::vector<Measured> cases);
/// [{"transport", "readers", "p50_us", "p99_us", "max_us"}, ...]
std::string json(std::vector<Measured> cases);

} // namespace afterglow::bench
