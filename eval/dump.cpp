// SPDX-License-Identifier: Apache-2.0
#include "eval/dump.hpp"

#include "core/base/write_file.hpp"
#include "drivers/files/image_file.hpp"

#include <fmt/format.h>

#include <filesystem>

namespace afterglow {
namespace {

std::string cell(const std::optional<double> &value) {
    return value ? fmt::format("{:.4f}", *value) : "";
}

const char *source_of(const FrameScore &frame) {
    if (frame.skipped)
        return "skipped";
    if (frame.is_empty)
        return "none";
    return frame.measured ? "measured" : "estimated";
}

} // namespace

Status make_folder(const std::string &folder) {
    std::error_code error;
    std::filesystem::create_directories(folder, error);
    if (error)
        return Error{fmt::format("{}: {}", folder, error.message()), error.value()};
    return ok();
}

Status dump_depth(const std::string &folder, std::uint64_t index, DepthView depth) {
    return write_png(fmt::format("{}/{:06}.png", folder, index), depth);
}

Status write_frames_csv(const std::string &path, const Evaluation &evaluation) {
    std::string csv = "index,t_ns,source,age_frames,expected_mre,mre,coverage,inliers,lit\n";
    for (const FrameScore &frame : evaluation.frames)
        csv += fmt::format("{},{},{},{},{},{},{},{},{:d}\n", frame.index, frame.t_ns,
                           source_of(frame), frame.age_frames, cell(frame.expected_mre),
                           cell(frame.mre), cell(frame.coverage), frame.inliers, frame.lit);
    return write_file(path, csv);
}

} // namespace afterglow
