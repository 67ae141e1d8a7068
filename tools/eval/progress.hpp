// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <chrono>
#include <string>

namespace afterglow {

/// A line on a terminal's standard error that tells how far a long job is and how long it has to
/// go. Silent in the first two seconds, and where standard error is no terminal.
class Progress {
public:
    Progress(std::string what, int total);
    ~Progress();
    Progress(const Progress &) = delete;
    Progress &operator=(const Progress &) = delete;

    void update(int done);

private:
    std::string what_;
    int total_;
    bool terminal_;
    bool shown_ = false;
    std::chrono::steady_clock::time_point start_;
    std::chrono::steady_clock::time_point last_;
};

} // namespace afterglow
