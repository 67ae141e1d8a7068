// SPDX-License-Identifier: Apache-2.0
#include "core/base/standard_output.hpp"
#include "tools/ctl/command.hpp"
#include "tools/ctl/frame_json.hpp"
#include "tools/ctl/stream.hpp"

#include <fmt/format.h>

#include <cstdint>
#include <limits>
#include <memory>

namespace afterglow {
namespace {

// At most 40 columns, plain text whatever stdout is.
constexpr const char *heading = " frame depth    light age cover  err lat\n"
                                "                      frm     %    %  ms\n";

const char *name(std::uint32_t source) {
    switch (source) {
    case AFTERGLOW_MEASURED:
        return "measured";
    case AFTERGLOW_ESTIMATED:
        return "estimate";
    default:
        return "none";
    }
}

/// Writes the line at once, also into a pipe. Errors: stdout cannot be written.
Status print(const afterglow_frame &frame) {
    const double error = static_cast<double>(frame.expected_mre);
    const auto latency_ns = since_capture_ns(frame, frame.published_ns);
    fmt::print("{:>6} {:<8} {:<5} {:>3} {:>5.1f} {:>4} {:>3}\n", frame.index, name(frame.source),
               frame.emitter == AFTERGLOW_EMITTER_ON ? "lit" : "dark", frame.age_frames,
               static_cast<double>(frame.coverage),
               error < 0 ? "-" : fmt::format("{:.{}f}", error, error < 9.995 ? 2 : 1),
               latency_ns ? fmt::format("{:.0f}", static_cast<double>(*latency_ns) * 1e-6) : "-");
    return flush_standard_output();
}

Result<int> monitor(const Settings &settings, int frames) {
    Result<Stream> stream = Stream::open(settings.bus, Stream::Planes::depth);
    if (!stream)
        return stream.error();
    if (!settings.json)
        fmt::print("{}", heading);
    for (int count = 0; frames == 0 || count < frames; ++count) {
        const Result<afterglow_frame> frame = stream->next();
        if (!frame)
            return frame.error();
        const Status printed = settings.json ? print_json_line(to_json(*frame)) : print(*frame);
        if (!printed)
            return printed.error();
    }
    if (const std::uint64_t skipped = stream->skipped(); skipped > 0 && !settings.json)
        fmt::print("{} more frames were not shown\n", skipped);
    return 0;
}

} // namespace

Action declare_monitor(CLI::App &app, const Settings &settings) {
    const auto frames = std::make_shared<int>(0);
    app.add_option("--frames", *frames, "stop after so many; 0 = never")
        ->type_name("N")
        ->check(CLI::Range(0, std::numeric_limits<int>::max()));
    return [&settings, frames] { return monitor(settings, *frames); };
}

} // namespace afterglow
