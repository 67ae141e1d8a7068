// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "core/base/result.hpp"
#include "tools/bench/frames.hpp"

#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

namespace afterglow::bench {

/// A kind of processor that instructions are counted for.
struct Target {
    std::string_view name; ///< and the build folder of its program
    std::string_view core;
    std::string_view emulator; ///< a program of qemu-user
    std::string_view cpu;      ///< as the emulator calls it
    std::string_view addr2line;
};
inline constexpr Target targets[] = {
    {"armv7", "Cortex-A7", "qemu-arm", "cortex-a7", "arm-linux-gnueabihf-addr2line"},
    {"aarch64", "Cortex-A53", "qemu-aarch64", "cortex-a53", "aarch64-linux-gnu-addr2line"},
};

/// Instructions of one frame.
struct FrameCount {
    std::uint64_t track = 0;           ///< in Pipeline::track()
    std::uint64_t measure = 0;         ///< in Pipeline::measure(); 0: the frame was not measured
    std::vector<std::uint64_t> stages; ///< of both, in the order of Counts::stages
    std::uint64_t sum() const { return track + measure; }
};

struct Counts {
    /// Source files of core/ without ".cpp". An instruction belongs to the innermost of them that
    /// it was inlined into; what belongs to none is a library's.
    std::vector<std::string> stages;
    std::vector<FrameCount> frames;
    std::vector<FrameCount> still; ///< of the last image, shown again
};

/// Writes frames as the counted program reads them (frames_file.hpp).
Status write_frames(const Frames &frames, const std::string &path);

/// What the counted program has to do.
struct CountedRun {
    Target target;
    std::string program; ///< afterglow-counted, for the target
    std::string preset;
    std::string frames_file;
    int frames = 0;            ///< in that file
    int still = 0;             ///< how often the last image is shown again
    bool depth_alone = false;  ///< nobody wants confidences
    int depth_interval_ms = 0; ///< between depth maps, at most; 0: a map for every image
    std::string folder;        ///< for what is written on the way; of this run alone
};

/// Runs the program under the emulator and counts its instructions; the same run gives the same
/// counts on every machine. Errors: what is not installed, or what went wrong.
Result<Counts> count_instructions(const CountedRun &run);

} // namespace afterglow::bench
