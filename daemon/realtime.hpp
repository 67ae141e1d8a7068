// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "core/base/result.hpp"

namespace afterglow {

/// Gives the calling thread SCHED_FIFO at `priority` (1 to 99) and locks the process's memory, now
/// and in future. Threads it makes later inherit the priority. Errors: EPERM and what limit is
/// missing; the thread then goes on as it was.
Status become_realtime(int priority);

} // namespace afterglow
