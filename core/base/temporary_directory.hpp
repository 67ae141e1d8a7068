// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "core/base/result.hpp"

#include <string>
#include <utility>

namespace afterglow {

/// A new directory below $TMPDIR (or /tmp), removed with its content by the destructor.
class TemporaryDirectory {
public:
    /// `prefix` begins its name. Errors: the errno of mkdtemp().
    static Result<TemporaryDirectory> create(const std::string &prefix);
    TemporaryDirectory(TemporaryDirectory &&other) noexcept
        : path_(std::exchange(other.path_, {})) {}
    TemporaryDirectory &operator=(TemporaryDirectory &&) = delete;
    ~TemporaryDirectory();

    const std::string &path() const { return path_; }

private:
    explicit TemporaryDirectory(std::string path) : path_(std::move(path)) {}
    std::string path_;
};

} // namespace afterglow
