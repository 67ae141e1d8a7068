// SPDX-License-Identifier: Apache-2.0
#include "tools/ctl/commands.hpp"
#include "tools/ctl/stream.hpp"

#include <fmt/format.h>

#include <cstdint>
#include <cstdio>

namespace afterglow {
namespace {

const char *name(std::uint32_t source) {
    switch (source) {
    case AFTERGLOW_MEASURED:
        return "measured";
    case AFTERGLOW_ESTIMATED:
        return "estimated";
    default:
        return "no depth";
    }
}

void print(const afterglow_frame &frame) {
    fmt::print("{:>8}  {:<9}  {:<5}  {:>4}  {:>7.1f} %", frame.index, name(frame.source),
               frame.illuminated ? "lit" : "dark", frame.age_frames,
               static_cast<double>(frame.coverage));
    if (frame.expected_mre >= 0)
        fmt::print("  {:>6.2f} %", static_cast<double>(frame.expected_mre));
    else
        fmt::print("  {:>8}", "-");
    fmt::print("  {:>6.1f} ms\n", static_cast<double>(frame.published_ns - frame.t_ns) * 1e-6);
    std::fflush(stdout); // a line per frame, also into a pipe
}

} // namespace

Status monitor(const std::string &bus, int frames) {
    Result<Stream> stream = Stream::open(bus);
    if (!stream)
        return stream.error();
    fmt::print("{:>8}  {:<9}  {:<5}  {:>4}  {:>9}  {:>8}  {:>9}\n", "frame", "depth", "light",
               "age", "coverage", "error", "latency");
    for (int count = 0; frames == 0 || count < frames; ++count) {
        const Result<afterglow_frame> frame = stream->next();
        if (!frame)
            return frame.error();
        print(*frame);
    }
    if (const std::uint64_t skipped = stream->skipped(); skipped > 0)
        fmt::print("{} more frames came and went between these\n", skipped);
    return ok();
}

} // namespace afterglow
