// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "core/base/result.hpp"
#include "core/base/unique_fd.hpp"

#include <sys/types.h>

#include <string>
#include <string_view>

namespace afterglow {

// Errors carry errno, as ENOSPC where the disk is full, and say `PATH cannot be written: why`.

/// A file that is opened before there is anything to write, so that it is known early whether it
/// can be. Under its name there is the old file or the new one, as a whole, at all times: a part is
/// written beside it and renamed. A device, a pipe or a symbolic link is written into instead.
class OutputFile {
public:
    /// `mode`: the rights of the file, less the umask.
    static Result<OutputFile> open(const std::string &path, mode_t mode = 0666);
    OutputFile(OutputFile &&) = default;
    OutputFile &operator=(OutputFile &&) = delete;
    /// Without write() or finish() all is as it was.
    ~OutputFile();

    /// Writes all of the file and gives it its name.
    Status write(std::string_view bytes) &&;

    // The same in steps.
    int fd() const { return file_.get(); }
    Error error() const; ///< of errno as it is
    Status finish();

private:
    OutputFile(std::string path, std::string part, UniqueFd file)
        : path_(std::move(path)), part_(std::move(part)), file_(std::move(file)) {}

    std::string path_;
    std::string part_; ///< "": written in place
    UniqueFd file_;    ///< closed: finished
};

/// Writes a whole file, as OutputFile does.
Status write_file(const std::string &path, std::string_view bytes);

/// Makes a file; never over one that somebody has written (EEXIST). No part of it is left after an
/// error.
Status write_new_file(const std::string &path, std::string_view bytes);

/// Writes all bytes to a descriptor that waits; false with errno where it refuses.
bool write_all(int fd, std::string_view bytes);

} // namespace afterglow
