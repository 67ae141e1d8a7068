// SPDX-License-Identifier: Apache-2.0
#include "tests/attackers/attack.hpp"

#include <unistd.h>

namespace afterglow::attack {

/// Closes its stream and goes on looking at the memory: each second it says how many frames it has
/// seen there.
int ghost(const std::string &from) {
    std::vector<Memory> memories;
    {
        const UniqueFd socket = open_stream(from);
        memories = first_memories(socket.get());
    }
    say("ready");
    for (;;) {
        const std::uint64_t before = memories[0].head();
        ::sleep(1);
        say("saw " + std::to_string(memories[0].head() - before));
    }
}

/// Keeps every memory that its stream ever gets, and says how many that are.
int hoarder(const std::string &from) {
    const UniqueFd socket = open_stream(from);
    std::vector<Memory> hoard = first_memories(socket.get());
    say("ready");
    afterglow_message message;
    std::vector<Memory> more;
    while (receive(socket.get(), message, more)) {
        if (more.empty())
            continue;
        for (Memory &memory : more)
            hoard.push_back(std::move(memory));
        say("has " + std::to_string(hoard.size()));
    }
    say("ended");
    ::pause();
    return 0;
}

/// Opens a stream and never takes anything from it.
int mute(const std::string &from) {
    const UniqueFd socket = open_stream(from);
    say("ready");
    ::pause();
    return 0;
}

} // namespace afterglow::attack
