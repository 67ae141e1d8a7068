// SPDX-License-Identifier: Apache-2.0
#include "daemon/realtime.hpp"

#include <fmt/format.h>
#include <sys/mman.h>
#include <sys/resource.h>

#include <cerrno>
#include <cstring>
#include <pthread.h>
#include <sched.h>

namespace afterglow {

Status become_realtime(int priority) {
    sched_param parameters = {};
    parameters.sched_priority = priority;
    if (const int error = ::pthread_setschedparam(::pthread_self(), SCHED_FIFO, &parameters))
        return Error{fmt::format("no real-time priority {}: {} (LimitRTPRIO= in the unit, or "
                                 "CAP_SYS_NICE)",
                                 priority, std::strerror(error)),
                     error};
    // Under a limit, locking the future would turn an ordinary allocation into a failure.
    rlimit limit = {};
    if (::getrlimit(RLIMIT_MEMLOCK, &limit) != 0 || limit.rlim_cur != RLIM_INFINITY)
        return Error{"memory is not locked: it needs LimitMEMLOCK=infinity in the unit", EPERM};
    if (::mlockall(MCL_CURRENT | MCL_FUTURE) != 0)
        return Error{fmt::format("memory is not locked: {}", std::strerror(errno)), errno};
    return ok();
}

} // namespace afterglow
