// SPDX-License-Identifier: Apache-2.0
#include "daemon/log.hpp"

#include <fmt/format.h>
#include <sys/stat.h>

#include <cstdio>
#include <cstdlib>
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

void log(Priority priority, std::string_view sentence) {
    static const bool journal = stderr_is_journal();
    if (journal)
        fmt::print(stderr, "<{}>{}\n", static_cast<int>(priority), sentence);
    else
        fmt::print(stderr, "afterglowd: {}\n", sentence);
}

} // namespace afterglow
