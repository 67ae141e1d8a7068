// SPDX-License-Identifier: Apache-2.0
#include "eval/experiments/watch.hpp"

#include <algorithm>
#include <atomic>
#include <csignal>

namespace afterglow {
namespace {

std::atomic<bool> stop_asked = false;
static_assert(std::atomic<bool>::is_always_lock_free); // a signal handler writes it

} // namespace

void Watch::begin(const std::string &what, double work) {
    const std::lock_guard lock(mutex_);
    end_ = done_ + work;
    progress_.set_what(what);
}

void Watch::tick(double work) {
    const std::lock_guard lock(mutex_);
    done_ = std::min(done_ + work, end_);
    progress_.update(done_);
}

void Watch::end() {
    const std::lock_guard lock(mutex_);
    done_ = end_;
    progress_.update(done_);
}

void Watch::add(double work) {
    const std::lock_guard lock(mutex_);
    total_ += work;
    progress_.set_total(total_);
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
