// SPDX-License-Identifier: Apache-2.0
#include "tools/bench/arm/counting.hpp"

#include "core/base/child_process.hpp"
#include "core/base/unique_fd.hpp"
#include "tools/bench/arm/frames_file.hpp"
#include "tools/bench/arm/marks.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cerrno>
#include <chrono>
#include <fcntl.h>
#include <fstream>
#include <map>
#include <sstream>
#include <unordered_map>
#include <utility>

namespace afterglow::bench {
namespace {

constexpr auto longest_run = std::chrono::minutes(30);

/// Runs a program to its end. `input` and `output`: files, empty: this process's own.
Status run_to_end(std::vector<std::string> command, const std::string &input = {},
                  const std::string &output = {}) {
    const std::string name = command[0];
    ChildOptions options{.command = std::move(command)};
    const UniqueFd in(input.empty() ? -1 : ::open(input.c_str(), O_RDONLY | O_CLOEXEC));
    const UniqueFd out(
        output.empty() ? -1
                       : ::open(output.c_str(), O_WRONLY | O_CREAT | O_TRUNC | O_CLOEXEC, 0600));
    if (in.get() >= 0)
        options.descriptors.emplace_back(in.get(), 0);
    if (out.get() >= 0)
        options.descriptors.emplace_back(out.get(), 1);
    auto child = ChildProcess::start(options);
    if (!child)
        return child.error();
    const auto code = child->wait(longest_run);
    if (!code)
        return Error{name + " does not end", ETIMEDOUT};
    if (*code != 0)
        return Error{fmt::format("{} fails ({})", name, *code), EIO};
    return ok();
}

/// How often each block of instructions ran in a part of a frame.
struct PartCount {
    Mark part;
    std::size_t frame;
    std::vector<std::pair<std::size_t, std::uint64_t>> blocks;
};

struct BlockCounts {
    std::vector<PartCount> parts;
    std::vector<std::vector<std::uint64_t>> addresses; ///< of each block's instructions
};

/// What the plugin wrote.
Result<BlockCounts> read_block_counts(const std::string &path) {
    std::ifstream file(path);
    BlockCounts counts;
    bool complete = false;
    for (std::string line; std::getline(file, line);) {
        std::istringstream words(line);
        if (line == "blocks") {
            complete = true;
        } else if (complete) {
            std::size_t block = 0;
            words >> block >> std::hex;
            auto &addresses = counts.addresses.emplace_back();
            for (std::uint64_t address = 0; words >> address;)
                addresses.push_back(address);
        } else if (line.starts_with("part ")) {
            int part = 0;
            std::size_t frame = 0;
            words.ignore(5) >> part >> frame;
            counts.parts.push_back({static_cast<Mark>(part), frame, {}});
        } else if (!counts.parts.empty()) {
            std::size_t block = 0;
            std::uint64_t count = 0;
            words >> block >> count;
            counts.parts.back().blocks.emplace_back(block, count);
        }
    }
    if (!complete)
        return Error{"the emulator has counted nothing; is it QEMU 7 or later, with plugins?", EIO};
    return counts;
}

/// "warp/warp" for a file of core/; empty for any other. `place`: FILE:LINE.
std::string stage_of(std::string_view place) {
    const std::size_t end = place.rfind(".cpp:");
    const std::size_t core = place.substr(0, end).rfind("/core/");
    if (end == std::string_view::npos || core == std::string_view::npos)
        return {};
    return std::string(place.substr(core + 6, end - core - 6));
}

/// The stage of each instruction, as its debugging information tells.
Result<std::unordered_map<std::uint64_t, std::string>> find_stages(const CountedRun &run,
                                                                   const BlockCounts &counts) {
    const std::string input = run.folder + "/addresses";
    const std::string output = run.folder + "/places";
    std::unordered_map<std::uint64_t, std::string> stages;
    {
        std::ofstream file(input);
        for (const PartCount &part : counts.parts)
            for (const auto &[block, count] : part.blocks)
                for (const std::uint64_t address : counts.addresses[block])
                    if (stages.try_emplace(address).second)
                        file << fmt::format("{:x}\n", address);
    }
    if (Status ran = run_to_end({std::string(run.target.addr2line), "-a", "-i", "-e", run.program},
                                input, output);
        !ran)
        return ran.error();
    // "0xADDRESS", then the places that it was inlined from, the innermost first.
    std::ifstream file(output);
    std::string *stage = nullptr;
    for (std::string line; std::getline(file, line);) {
        if (line.starts_with("0x"))
            stage = &stages[std::stoull(line, nullptr, 16)];
        else if (stage != nullptr && stage->empty())
            *stage = stage_of(line);
    }
    return stages;
}

Counts sum_up(const CountedRun &run, const BlockCounts &counts,
              const std::unordered_map<std::uint64_t, std::string> &stages) {
    Counts sums;
    std::map<std::string, std::size_t> order;
    for (const auto &[address, stage] : stages)
        order.try_emplace(stage);
    for (auto &[stage, index] : order) {
        index = sums.stages.size();
        sums.stages.push_back(stage.empty() ? "libraries" : stage);
    }
    sums.frames.resize(static_cast<std::size_t>(run.frames));
    sums.still.resize(static_cast<std::size_t>(run.still));
    for (const PartCount &part : counts.parts) {
        const bool moving = part.frame < sums.frames.size();
        FrameCount &frame =
            moving ? sums.frames[part.frame] : sums.still[part.frame - sums.frames.size()];
        frame.stages.resize(order.size());
        std::uint64_t &sum = part.part == Mark::measure ? frame.measure : frame.track;
        for (const auto &[block, count] : part.blocks) {
            sum += count * counts.addresses[block].size();
            for (const std::uint64_t address : counts.addresses[block])
                frame.stages[order.at(stages.at(address))] += count;
        }
    }
    return sums;
}

} // namespace

Status write_frames(const Frames &frames, const std::string &path) {
    const FramesHeader header{.fx = frames.camera.fx,
                              .fy = frames.camera.fy,
                              .cx = frames.camera.cx,
                              .cy = frames.camera.cy,
                              .width = frames.camera.width,
                              .height = frames.camera.height,
                              .frames = static_cast<std::int64_t>(frames.frames.size())};
    std::ofstream file(path, std::ios::binary);
    const auto write = [&](const void *data, std::size_t bytes) {
        file.write(static_cast<const char *>(data), static_cast<std::streamsize>(bytes));
    };
    write(&header, sizeof header);
    for (const DecodedFrame &frame : frames.frames) {
        write(&frame.t_ns, sizeof frame.t_ns);
        write(frame.luma.pixels().data(), frame.luma.pixels().size_bytes());
        write(frame.depth.pixels().data(), frame.depth.pixels().size_bytes());
    }
    if (!file.flush())
        return Error{path + " cannot be written", EIO};
    return ok();
}

Result<Counts> count_instructions(const CountedRun &run) {
    const std::string blocks = run.folder + "/blocks";
    if (Status ran = run_to_end(
            {std::string(run.target.emulator), "-cpu", std::string(run.target.cpu), "-plugin",
             std::string(AFTERGLOW_COUNTING_PLUGIN) + ",out=" + blocks, run.program,
             run.frames_file, run.preset, std::to_string(run.still),
             run.depth_alone ? "depth" : "confidence", std::to_string(run.depth_interval_ms)});
        !ran)
        return ran.error();
    const auto counts = read_block_counts(blocks);
    if (!counts)
        return counts.error();
    const int frames = run.frames + run.still;
    const auto outside = [&](const PartCount &part) {
        return part.frame >= static_cast<std::size_t>(frames);
    };
    if (counts->parts.empty() || std::ranges::any_of(counts->parts, outside))
        return Error{"the counted program has not marked its frames", EIO};
    const auto stages = find_stages(run, *counts);
    if (!stages)
        return stages.error();
    return sum_up(run, *counts, *stages);
}

} // namespace afterglow::bench
