// SPDX-License-Identifier: Apache-2.0
#include "tools/bench/ipc/results.hpp"

#include "core/base/percentiles.hpp"

#include <fmt/format.h>

#include <nlohmann/json.hpp>
#include <utility>

namespace afterglow::bench {
namespace {

/// Microseconds.
Percentiles percentiles(const std::vector<std::int64_t> &latencies_ns) {
    std::vector<double> us;
    for (const std::int64_t ns : latencies_ns)
        us.push_back(1e-3 * static_cast<double>(ns));
    return us.empty() ? Percentiles{} : percentiles_of(std::move(us));
}

} // namespace

std::string table(std::vector<Measured> cases) {
    std::string text = "publish to wake-up, us\n"
                       "transport   readers      p50      p99      max   missed frames\n";
    for (Measured &one : cases) {
        const Percentiles p = percentiles(one.result.latencies_ns);
        text += fmt::format("{:<11} {:7} {:8.0f} {:8.0f} {:8.0f}   {} of {}\n", one.transport,
                            one.readers, p.p50, p.p99, p.max, one.result.missed,
                            one.result.missed + one.result.latencies_ns.size());
    }
    return text;
}

std::string json(std::vector<Measured> cases) {
    nlohmann::ordered_json array = nlohmann::ordered_json::array();
    for (Measured &one : cases) {
        const Percentiles p = percentiles(one.result.latencies_ns);
        array.push_back({{"transport", one.transport},
                         {"readers", one.readers},
                         {"p50_us", p.p50},
                         {"p99_us", p.p99},
                         {"max_us", p.max}});
    }
    return array.dump(2) + "\n";
}

} // namespace afterglow::bench
