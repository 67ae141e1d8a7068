// SPDX-License-Identifier: Apache-2.0
#include "core/base/log.hpp"

#include <fmt/format.h>
#include <sys/stat.h>

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

} // namespace

void log(Priority priority, std::string_view sentence) noexcept {
    try {
        static const bool journal = stderr_is_journal();
        const std::string prefix = journal ? fmt::format("<{}>", static_cast<int>(priority))
                                           : fmt::format("{}: ", ::program_invocation_short_name);
        const std::string line = fmt::format("{}{}\n", prefix, sentence);
        // One call, so that lines of several threads do not mix.
        [[maybe_unused]] const ssize_t written = ::write(STDERR_FILENO, line.data(), line.size());
    } catch (const std::exception &) { // out of memory: the line is lost
    }
}

} // namespace afterglow
