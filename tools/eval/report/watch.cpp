// SPDX-License-Identifier: Apache-2.0
#include "tools/eval/report/watch.hpp"

#include <atomic>
#include <csignal>

namespace afterglow {
namespace {

std::atomic<bool> stop_asked = false;
static_assert(std::atomic<bool>::is_always_lock_free); // a signal handler writes it

} // namespace

void Watch::tick() const {
    const std::lock_guard lock(mutex_);
    progress_.update(++done_);
}

bool Watch::stopped() {
    return stop_asked;
}

void Watch::heed_signals() {
    struct sigaction action {};
    action.sa_handler = [](int) { stop_asked = true; };
    action.sa_flags = static_cast<int>(SA_RESETHAND | SA_RESTART);
    sigaction(SIGINT, &action, nullptr);
    sigaction(SIGTERM, &action, nullptr);
}

} // namespace afterglow
