// SPDX-License-Identifier: Apache-2.0
#include "tools/eval/progress.hpp"

#include <fmt/format.h>

#include <cstdio>
#include <unistd.h>
#include <utility>

namespace afterglow {
namespace {

constexpr auto quiet_time = std::chrono::seconds(2);
constexpr auto refresh = std::chrono::milliseconds(200);

} // namespace

Progress::Progress(std::string what, int total)
    : what_(std::move(what)), total_(total), terminal_(::isatty(STDERR_FILENO) == 1),
      start_(std::chrono::steady_clock::now()), last_(start_) {}

Progress::~Progress() {
    if (shown_)
        fmt::print(stderr, "\r\033[K");
}

void Progress::update(int done) {
    const auto now = std::chrono::steady_clock::now();
    if (!terminal_ || done <= 0 || now - start_ < quiet_time || now - last_ < refresh)
        return;
    last_ = now;
    shown_ = true;
    const double passed = std::chrono::duration<double>(now - start_).count();
    const double left = passed / done * (total_ - done);
    fmt::print(stderr, "\r\033[K{}: {} of {} frames, {:.0f} s left", what_, done, total_, left);
    std::fflush(stderr);
}

} // namespace afterglow
