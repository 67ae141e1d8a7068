// SPDX-License-Identifier: Apache-2.0
#include "daemon/note_log.hpp"

#include <fmt/format.h>

namespace afterglow {

std::optional<std::string> NoteLog::line(const Note &note, Time now) {
    const bool repeated = note.sentence() == last_;
    if (repeated && now - last_logged_ < quiet) {
        ++repeats_;
        return std::nullopt;
    }
    std::string line(note.sentence());
    if (repeated && repeats_ > 0)
        line += fmt::format(" ({} times more)", repeats_);
    last_ = note.sentence();
    last_logged_ = now;
    repeats_ = 0;
    return line;
}

} // namespace afterglow
