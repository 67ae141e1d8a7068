// SPDX-License-Identifier: Apache-2.0
#include "daemon/note_log.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <utility>

namespace afterglow {

std::optional<std::string> NoteLog::line(const Note &note, Time now) {
    std::string line(note.sentence());
    auto said = std::ranges::find(said_, line, &Said::sentence);
    if (said == said_.end()) {
        if (said_.size() == most)
            said_.erase(std::ranges::min_element(said_, {}, &Said::logged));
        said_.push_back({line, now});
        return line;
    }
    if (now < said->logged + quiet) {
        ++said->repeats;
        return std::nullopt;
    }
    said->logged = now;
    if (const std::uint64_t repeats = std::exchange(said->repeats, 0); repeats > 0)
        line += fmt::format(" ({} times more)", repeats);
    return line;
}

void NoteLog::recovered() {
    for (Said &said : said_)
        said.logged = Time::min();
}

} // namespace afterglow
