// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "daemon/outbox.hpp"

#include <chrono>
#include <cstdint>
#include <optional>
#include <string>

namespace afterglow {

/// Turns notes into lines, and thirty of the same a second into one every ten seconds.
class NoteLog {
public:
    using Time = std::chrono::steady_clock::time_point;
    static constexpr std::chrono::seconds quiet = std::chrono::seconds(10);

    /// The line to log for a note, if it is time for one.
    std::optional<std::string> line(const Note &note, Time now);

private:
    std::string last_;
    Time last_logged_;
    std::uint64_t repeats_ = 0; ///< not told yet
};

} // namespace afterglow
