// SPDX-License-Identifier: Apache-2.0
#include "core/base/percentiles.hpp"
#include "tools/ctl/command.hpp"
#include "tools/ctl/json.hpp"
#include "tools/ctl/stream.hpp"

#include <fmt/format.h>

#include <chrono>
#include <limits>
#include <memory>
#include <vector>

namespace afterglow {
namespace {

/// null where there are no times.
Json to_json(const std::vector<double> &times_ns) {
    if (times_ns.empty())
        return nullptr;
    const Percentiles percentiles = percentiles_of(times_ns);
    return {{"p50_us", percentiles.p50 / 1000},
            {"p99_us", percentiles.p99 / 1000},
            {"max_us", percentiles.max / 1000}};
}

void print_row(const char *what, const std::vector<double> &times_ns) {
    if (times_ns.empty()) {
        fmt::print("{:<16} {:>8} {:>8} {:>8}\n", what, "-", "-", "-");
        return;
    }
    const Percentiles percentiles = percentiles_of(times_ns);
    fmt::print("{:<16} {:>8.2f} {:>8.2f} {:>8.2f}\n", what, percentiles.p50 * 1e-6,
               percentiles.p99 * 1e-6, percentiles.max * 1e-6);
}

Result<int> measure(const Settings &settings, int frames) {
    Result<Stream> stream = Stream::open(settings.bus, Stream::Planes::depth);
    if (!stream)
        return stream.error();
    std::vector<double> from_capture; // ns, of frames that were captured now
    std::vector<double> from_publication;
    for (int count = 0; count < frames; ++count) {
        const Result<afterglow_frame> frame = stream->next();
        if (!frame)
            return frame.error();
        // CLOCK_MONOTONIC, as the frame's times are.
        const std::int64_t here_ns = std::chrono::steady_clock::now().time_since_epoch().count();
        if (const auto since_ns = since_capture_ns(*frame, here_ns))
            from_capture.push_back(static_cast<double>(*since_ns));
        from_publication.push_back(static_cast<double>(here_ns - frame->published_ns));
    }
    if (settings.json)
        return print_json({{"frames", frames},
                           {"skipped", stream->skipped()},
                           {"capture_to_here", to_json(from_capture)},
                           {"publish_to_here", to_json(from_publication)}});
    fmt::print("{:<16} {:>8} {:>8} {:>8}\n", "ms", "p50", "p99", "max");
    print_row("capture to here", from_capture);
    print_row("publish to here", from_publication);
    fmt::print("{} frames, {} skipped\n", frames, stream->skipped());
    return 0;
}

} // namespace

Action declare_latency(CLI::App &app, const Settings &settings) {
    const auto frames = std::make_shared<int>(300);
    app.add_option("--frames", *frames, "measure so many")
        ->type_name("N")
        ->check(CLI::Range(1, std::numeric_limits<int>::max()))
        ->capture_default_str();
    return [&settings, frames] { return measure(settings, *frames); };
}

} // namespace afterglow
