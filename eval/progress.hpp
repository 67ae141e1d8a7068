// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <chrono>
#include <string>
#include <utility>

namespace afterglow {

/// A bar on a terminal's standard error that tells how far a long job is and how long it has to
/// go. Silent in the first two seconds, and where standard error is no terminal.
class Progress {
public:
    /// `total`: of frames, or of whatever else takes equally long.
    Progress(std::string what, double total);
    ~Progress();
    Progress(const Progress &) = delete;
    Progress &operator=(const Progress &) = delete;

    void set_what(std::string what) { what_ = std::move(what); }
    void set_total(double total) { total_ = total; }
    void update(double done);

private:
    std::string what_;
    double total_;
    bool terminal_;
    bool shown_ = false;
    std::chrono::steady_clock::time_point start_;
    std::chrono::steady_clock::time_point last_;
};

/// "[#####---------------]  25 %, 1 min 30 s left: room". `share`: done, 0 to 1.
std::string progress_line(const std::string &what, double share, std::chrono::seconds left);

} // namespace afterglow
