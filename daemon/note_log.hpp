// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "daemon/outbox.hpp"

#include <chrono>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

namespace afterglow {

/// Limits the log: of equal notes one every ten seconds is logged, with the count of those between.
/// The notes logged last are remembered, up to a number.
class NoteLog {
public:
    using Time = std::chrono::steady_clock::time_point;
    static constexpr std::chrono::seconds quiet = std::chrono::seconds(10);
    static constexpr std::size_t most = 8; ///< different notes that are remembered

    /// The line to log for `note`; nothing when the same was logged less than `quiet` ago.
    std::optional<std::string> line(const Note &note, Time now);

    /// The cameras run again: what goes wrong from now on is logged at once, also when it was
    /// logged less than `quiet` ago.
    void recovered();

private:
    struct Said {
        std::string sentence;
        Time logged;               ///< Time::min() after recovered()
        std::uint64_t repeats = 0; ///< not logged yet
    };
    std::vector<Said> said_;
};

} // namespace afterglow
