// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "core/base/result.hpp"
#include "core/base/temporary_directory.hpp"
#include "eval/datasets/alteration.hpp"

#include <cstddef>
#include <functional>
#include <optional>
#include <string>

namespace afterglow {

struct ImportOptions {
    std::string layout;     ///< one of dataset_layouts(); empty = recognised by its files
    std::size_t frames = 0; ///< stop after so many good ones; 0 = all
    /// Called after each frame: how many of how many were looked at. False stops there.
    std::function<bool(std::size_t done, std::size_t of)> progress;
};

struct ImportSummary {
    std::string layout;
    std::string assumed;    ///< what the dataset does not say; see Dataset::assumed
    std::size_t frames = 0; ///< written, at least one
    /// Left out when files were paired, or because an image or depth map could not be read; and
    /// the first reason.
    std::size_t skipped = 0;
    std::string skipped_reason;
};

/// Turns a sequence of any known layout into a recording that replay reads: the folder
/// `destination`, with images as luma and depth registered to them in millimetres. One frame at a
/// time; what was written stays readable when it stops early. A destination that holds a recording
/// is refused. `alteration`: of all frames.
Result<ImportSummary> import_dataset(const std::string &source, const std::string &destination,
                                     const ImportOptions &options = {},
                                     const Alteration *alteration = nullptr);

/// A folder that replay reads, for a dataset in any layout. A recording is used where it is;
/// anything else is imported into a temporary folder, which goes with this object.
class ReplayFolder {
public:
    static Result<ReplayFolder> prepare(const std::string &source,
                                        const ImportOptions &options = {});

    const std::string &path() const { return path_; }
    /// Of the import; a recording that is used where it is has only its layout here.
    const ImportSummary &summary() const { return summary_; }

private:
    ReplayFolder() = default;

    std::string path_;
    std::optional<TemporaryDirectory> temporary_; ///< where an imported recording lies
    ImportSummary summary_;
};

} // namespace afterglow
