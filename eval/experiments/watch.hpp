// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "eval/progress.hpp"

#include <mutex>
#include <string>

namespace afterglow {

/// How far a long job is, for the person who waits, and whether that person has had enough. Work
/// is counted in frames of the paper's system, or in what takes as long. Any thread.
class Watch {
public:
    /// `total`: work of the whole job, as far as it is known.
    explicit Watch(double total) : total_(total), progress_("", total) {}

    /// The job goes on with something else, in whose course `work` is expected.
    void begin(const std::string &what, double work);
    /// Some of it is done.
    void tick(double work = 1);
    /// All of it is, whatever was ticked.
    void end();
    /// There turned out to be more or, negative, less to do.
    void add(double work);

    /// Whether Ctrl-C was pressed: finish with what there is.
    static bool stopped();

    /// From now on the first SIGINT or SIGTERM makes stopped() true, and a second one kills.
    static void heed_signals();

private:
    std::mutex mutex_;
    double total_;
    double done_ = 0;
    double end_ = 0; ///< done_ when what has begun will be over
    Progress progress_;
};

} // namespace afterglow
