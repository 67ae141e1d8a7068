// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "drivers/files/recording.hpp"

#include <cstdint>
#include <vector>

namespace afterglow {

/// The schedule of a recording that is played in a loop. Each round begins at a whole multiple of
/// its length on CLOCK_MONOTONIC, so that all processes that play it show the same frame.
class Rounds {
public:
    struct Frame {
        std::int64_t due_ns = 0;
        std::uint64_t number = 0; ///< in the recording
    };

    /// `speed`: of the recorded pace, more than 0.
    explicit Rounds(const Recording &recording, double speed = 1);

    std::int64_t length_ns() const { return length_ns_; }
    /// The first frame that is due after `t_ns`.
    Frame next(std::int64_t t_ns) const;

private:
    std::int64_t length_ns_;
    std::vector<std::int64_t> offsets_ns_; ///< of the frames, in a round
};

} // namespace afterglow
