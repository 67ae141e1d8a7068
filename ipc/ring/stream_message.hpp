// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "ipc/ring/ring_writer.hpp"

#include <cstdint>

/// The datagrams of a stream (afterglow_message), as the daemon sends them. None blocks or raises
/// SIGPIPE; false: the kernel refused, with its errno.
namespace afterglow {

bool send_frame(int socket, std::uint64_t index);
bool send_memory(int socket, const ReaderFds &memory, std::uint64_t generation);
/// Finds room although the socket is full: it is the last one.
bool send_end(int socket, int error);
/// Whether something sent before waits to be received.
bool has_unread(int socket);

} // namespace afterglow
