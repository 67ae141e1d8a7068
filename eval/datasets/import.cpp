// SPDX-License-Identifier: Apache-2.0
#include "eval/datasets/import.hpp"

#include "drivers/files/write_recording.hpp"
#include "eval/datasets/dataset.hpp"
#include "eval/datasets/layout.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cerrno>
#include <cstdlib>
#include <filesystem>
#include <optional>
#include <utility>

namespace afterglow {
namespace {

namespace fs = std::filesystem;

Result<ImportSummary> write(Dataset &dataset, const std::string &source,
                            const std::string &destination, const ImportOptions &options,
                            const Alteration *alteration) {
    ImportSummary summary{dataset.layout, dataset.assumed, 0, 0, {}};
    std::optional<RecordingWriter> writer; // nothing is made before there is a frame
    std::optional<FrameAlterer> alterer;
    if (alteration)
        alterer.emplace(*alteration);
    std::size_t done = 0;
    // How many frames will be looked at; each that is not written makes it one more.
    const auto wanted = [&] {
        const std::size_t all = dataset.frames.size();
        return options.frames > 0 ? std::min(all, options.frames - summary.frames + done) : all;
    };
    for (const Dataset::Frame &frame : dataset.frames) {
        if (options.frames > 0 && summary.frames == options.frames)
            break;
        Result<Luma> luma = dataset.read_luma(frame.color_path);
        Result<DepthMap> depth =
            luma ? dataset.read_depth(frame.depth_path) : Result<DepthMap>(luma.error());
        if (!depth) {
            skip(dataset, depth.error().message);
        } else if (!alterer || alterer->alter(luma->view(), *depth)) {
            if (!writer) {
                Result<RecordingWriter> made = RecordingWriter::create(destination, dataset.camera);
                if (!made)
                    return made.error();
                writer = *std::move(made);
            }
            if (Status added = writer->add(frame.t_ns, *luma, frame.depth_time_ns(), *depth,
                                           frame.camera_to_world);
                !added)
                return added.error();
            ++summary.frames;
        }
        ++done;
        if (options.progress && !options.progress(done, wanted()))
            break;
    }
    summary.skipped = dataset.skipped;
    summary.skipped_reason = dataset.skipped_reason;
    if (summary.frames == 0)
        return Error{fmt::format("{}: no frame could be read: {}", source,
                                 summary.skipped > 0 ? summary.skipped_reason
                                                     : "the alteration leaves out the only one"),
                     EINVAL};
    return summary;
}

} // namespace

Result<ImportSummary> import_dataset(const std::string &source, const std::string &destination,
                                     const ImportOptions &options, const Alteration *alteration) {
    Result<Dataset> dataset = open_dataset(source, options.layout);
    if (!dataset)
        return dataset.error();
    std::error_code problem;
    if (fs::equivalent(source, destination, problem))
        return Error{fmt::format("{}: cannot be imported into itself", source), EINVAL};
    if (!dataset->calibration.empty())
        return not_registered(source, dataset->calibration);
    return write(*dataset, source, destination, options, alteration);
}

Result<ReplayFolder> ReplayFolder::prepare(const std::string &source,
                                           const ImportOptions &options) {
    Result<Dataset> dataset = open_dataset(source, options.layout);
    if (!dataset)
        return dataset.error();
    ReplayFolder folder;
    if (dataset->layout == tum_layout.name) {
        folder.path_ = source;
        folder.summary_.layout = dataset->layout;
        return folder;
    }
    Result<TemporaryDirectory> directory = TemporaryDirectory::create("afterglow-import-");
    if (!directory)
        return directory.error();
    // The recording is named after the dataset, as reports show it.
    folder.path_ = directory->path() + "/" + folder_name(source);
    folder.temporary_.emplace(*std::move(directory));
    Result<ImportSummary> summary = write(*dataset, source, folder.path_, options, nullptr);
    if (!summary)
        return summary.error();
    folder.summary_ = *std::move(summary);
    return folder;
}

} // namespace afterglow
