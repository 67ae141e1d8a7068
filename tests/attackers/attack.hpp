// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "afterglow/ring.h"
#include "core/base/unique_fd.hpp"

#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

/// Clients that mean harm: what each does with a stream that it got as anybody does, without
/// libafterglow. Those that can fail to get what they need end with exit code 2 and say why.
namespace afterglow::attack {

/// One of a stream's memories, mapped as the daemon lets us. The mapping stays when it is
/// destroyed: attackers keep what they have got.
struct Memory {
    UniqueFd fd;
    const std::uint8_t *at = nullptr;
    std::size_t bytes = 0;

    const afterglow_ring_header &header() const {
        return *reinterpret_cast<const afterglow_ring_header *>(at);
    }
    std::uint64_t head() const;
};

/// Prints a line at once.
void say(const std::string &line);
/// Ends the program.
[[noreturn]] void give_up(const std::string &why);

/// A new stream's socket: "fd:N" is a descriptor that was inherited, everything else the address of
/// a bus with a daemon.
UniqueFd open_stream(const std::string &from);
/// The next datagram, and the memories that came with it; false when the stream has ended.
bool receive(int socket, afterglow_message &message, std::vector<Memory> &memories);
/// The memories of a stream that was opened just now.
std::vector<Memory> first_memories(int socket);

int crowd(const std::string &from);
int thief(const std::string &from);
int vandal(const std::string &from);
int ghost(const std::string &from);
int hoarder(const std::string &from);
int mute(const std::string &from);
int flapper(const std::string &bus);
int flood(const std::string &bus);
int petitioner(const std::string &bus);
/// No attacker: reads every frame through libafterglow, and tells what it got.
int reader(const std::string &from);

} // namespace afterglow::attack
