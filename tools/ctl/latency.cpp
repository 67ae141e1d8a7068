// SPDX-License-Identifier: Apache-2.0
#include "core/base/percentiles.hpp"
#include "tools/ctl/command.hpp"
#include "tools/ctl/json.hpp"
#include "tools/ctl/stream.hpp"

#include <fmt/format.h>

#include <chrono>
#include <memory>
#include <vector>

namespace afterglow {
namespace {

Json to_json(const Percentiles &percentiles) {
    return {{"p50_us", percentiles.p50 / 1000},
            {"p99_us", percentiles.p99 / 1000},
            {"max_us", percentiles.max / 1000}};
}

void print_row(const char *what, const Percentiles &percentiles) {
    fmt::print("{:<16} {:>8.2f} {:>8.2f} {:>8.2f}\n", what, percentiles.p50 * 1e-6,
               percentiles.p99 * 1e-6, percentiles.max * 1e-6);
}

Result<int> measure(const Settings &settings, int frames) {
    Result<Stream> stream = Stream::open(settings.bus, Stream::Planes::depth);
    if (!stream)
        return stream.error();
    std::vector<double> from_capture; // ns
    std::vector<double> from_publication;
    for (int count = 0; count < frames; ++count) {
        const Result<afterglow_frame> frame = stream->next();
        if (!frame)
            return frame.error();
        // CLOCK_MONOTONIC, as the frame's times are.
        const std::int64_t here_ns = std::chrono::steady_clock::now().time_since_epoch().count();
        from_capture.push_back(static_cast<double>(here_ns - frame->t_ns));
        from_publication.push_back(static_cast<double>(here_ns - frame->published_ns));
    }
    const Percentiles capture = percentiles_of(std::move(from_capture));
    const Percentiles publication = percentiles_of(std::move(from_publication));
    if (settings.json)
        return print_json({{"frames", frames},
                           {"skipped", stream->skipped()},
                           {"capture_to_here", to_json(capture)},
                           {"publish_to_here", to_json(publication)}});
    fmt::print("{:<16} {:>8} {:>8} {:>8}\n", "ms", "p50", "p99", "max");
    print_row("capture to here", capture);
    print_row("publish to here", publication);
    fmt::print("{} frames, {} skipped\n", frames, stream->skipped());
    return 0;
}

} // namespace

Action declare_latency(CLI::App &app, const Settings &settings) {
    const auto frames = std::make_shared<int>(300);
    app.add_option("--frames", *frames, "measure so many")
        ->type_name("N")
        ->check(CLI::PositiveNumber)
        ->capture_default_str();
    return [&settings, frames] { return measure(settings, *frames); };
}

} // namespace afterglow
