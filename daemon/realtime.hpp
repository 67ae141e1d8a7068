// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "core/base/result.hpp"

namespace afterglow {

/// Gives the calling thread SCHED_FIFO at `priority` (1 to 99) and locks the process's memory, now
/// and in future. Threads it makes later inherit the priority. Where it fails the thread goes on
/// as it was, and the error says what is missing.
Status become_realtime(int priority);

} // namespace afterglow
