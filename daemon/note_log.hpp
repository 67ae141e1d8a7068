// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "daemon/outbox.hpp"

#include <chrono>
#include <cstdint>
#include <optional>
#include <string>

namespace afterglow {

/// Limits the log: of equal notes in succession one every ten seconds is logged, with their count.
class NoteLog {
public:
    using Time = std::chrono::steady_clock::time_point;
    static constexpr std::chrono::seconds quiet = std::chrono::seconds(10);

    /// The line to log for `note`; nothing when the same was logged less than `quiet` ago.
    std::optional<std::string> line(const Note &note, Time now);

private:
    std::string last_;
    Time last_logged_;
    std::uint64_t repeats_ = 0; ///< not logged yet
};

} // namespace afterglow
