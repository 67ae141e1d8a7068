// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "tools/eval/progress.hpp"

#include <mutex>
#include <string>

namespace afterglow {

/// How far a long job is, for the person who waits, and whether that person has had enough. Any
/// thread.
class Watch {
public:
    Watch(const std::string &what, int total) : progress_(what, total) {}

    /// Another frame is done.
    void tick() const;
    /// Whether Ctrl-C was pressed: finish with what there is.
    static bool stopped();

    /// From now on the first SIGINT or SIGTERM makes stopped() true, and a second one kills.
    static void heed_signals();

private:
    mutable std::mutex mutex_;
    mutable Progress progress_;
    mutable int done_ = 0;
};

} // namespace afterglow
