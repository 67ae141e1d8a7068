// SPDX-License-Identifier: Apache-2.0
#include "eval/progress.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <unistd.h>
#include <utility>

namespace afterglow {
namespace {

constexpr auto quiet_time = std::chrono::seconds(2);
constexpr auto refresh = std::chrono::milliseconds(200);

} // namespace

Progress::Progress(std::string what, double total)
    : what_(std::move(what)), total_(total), terminal_(::isatty(STDERR_FILENO) == 1),
      start_(std::chrono::steady_clock::now()), last_(start_) {}

Progress::~Progress() {
    if (shown_)
        fmt::print(stderr, "\r\033[K");
}

void Progress::update(double done) {
    const auto now = std::chrono::steady_clock::now();
    if (!terminal_ || !(done > 0) || now - start_ < quiet_time || now - last_ < refresh)
        return;
    last_ = now;
    shown_ = true;
    const double share = std::min(done / total_, 1.0);
    const auto passed = std::chrono::duration<double>(now - start_);
    const auto left = std::chrono::ceil<std::chrono::seconds>(passed * ((1 - share) / share));
    fmt::print(stderr, "\r\033[K{}", progress_line(what_, share, left));
    std::fflush(stderr);
}

std::string progress_line(const std::string &what, double share, std::chrono::seconds left) {
    constexpr int width = 20;
    const int filled = static_cast<int>(share * width);
    const auto minutes = std::chrono::floor<std::chrono::minutes>(left);
    const auto seconds = (left - minutes).count();
    return fmt::format("[{:#<{}}{:-<{}}] {:3.0f} %, {}{} s left: {}", "", filled, "",
                       width - filled, std::floor(100 * share),
                       minutes.count() > 0 ? fmt::format("{} min ", minutes.count()) : "", seconds,
                       what);
}

} // namespace afterglow
