// SPDX-License-Identifier: Apache-2.0
#include "tools/bench/ipc/results.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>

namespace afterglow::bench {
namespace {

struct Percentiles {
    double p50_us = 0, p99_us = 0, max_us = 0;
};

Percentiles percentiles(std::vector<std::int64_t> &latencies_ns) {
    if (latencies_ns.empty())
        return {};
    std::sort(latencies_ns.begin(), latencies_ns.end());
    const auto at = [&](double share) {
        const double rank = std::ceil(share * static_cast<double>(latencies_ns.size()));
        return 1e-3 * static_cast<double>(latencies_ns[static_cast<std::size_t>(rank) - 1]);
    };
    return {at(0.5), at(0.99), at(1)};
}

} // namespace

std::string table(std::vector<Measured> cases) {
    std::string text = "publish to wake-up, us\n"
                       "transport   readers      p50      p99      max   missed frames\n";
    for (Measured &one : cases) {
        const Percentiles p = percentiles(one.result.latencies_ns);
        text += fmt::format("{:<11} {:7} {:8.0f} {:8.0f} {:8.0f}   {} of {}\n", one.transport,
                            one.readers, p.p50_us, p.p99_us, p.max_us, one.result.missed,
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
                         {"p50_us", p.p50_us},
                         {"p99_us", p.p99_us},
                         {"max_us", p.max_us}});
    }
    return array.dump(2) + "\n";
}

} // namespace afterglow::bench
