// SPDX-License-Identifier: Apache-2.0
#include "core/base/log.hpp"

#include <fmt/format.h>
#include <sys/stat.h>

#include <atomic>
#include <cerrno>
#include <cstdlib>
#include <exception>
#include <string>
#include <unistd.h>

namespace afterglow {
namespace {

/// JOURNAL_STREAM names the journal's socket; it is inherited even where stderr is redirected.
bool stderr_is_journal() {
    const char *stream = std::getenv("JOURNAL_STREAM");
    struct stat status = {};
    return stream && ::fstat(STDERR_FILENO, &status) == 0 &&
           fmt::format("{}:{}", status.st_dev, status.st_ino) == stream;
}

std::atomic<int> least_urgent = 7;

std::atomic<LogTarget> &target_variable() {
    static std::atomic<LogTarget> target =
        stderr_is_journal() ? LogTarget::journal : LogTarget::console;
    return target;
}

} // namespace

int log_level() noexcept {
    return least_urgent.load(std::memory_order_relaxed);
}

void set_log_level(int level) noexcept {
    least_urgent.store(level, std::memory_order_relaxed);
}

LogTarget log_target() noexcept {
    return target_variable().load(std::memory_order_relaxed);
}

bool set_log_target(LogTarget target) noexcept {
    if (target == LogTarget::journal && !stderr_is_journal())
        return false;
    target_variable().store(target, std::memory_order_relaxed);
    return true;
}

void log(Priority priority, std::string_view sentence) noexcept {
    const LogTarget target = log_target();
    if (static_cast<int>(priority) > log_level() || target == LogTarget::null)
        return;
    try {
        const std::string prefix = target == LogTarget::journal
                                       ? fmt::format("<{}>", static_cast<int>(priority))
                                       : fmt::format("{}: ", ::program_invocation_short_name);
        const std::string line = fmt::format("{}{}\n", prefix, sentence);
        // One call, so that lines of several threads do not mix.
        [[maybe_unused]] const ssize_t written = ::write(STDERR_FILENO, line.data(), line.size());
    } catch (const std::exception &) { // out of memory: the line is lost
    }
}

} // namespace afterglow
