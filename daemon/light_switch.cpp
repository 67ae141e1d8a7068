// SPDX-License-Identifier: Apache-2.0
#include "daemon/light_switch.hpp"

#include "core/base/clock.hpp"
#include "core/base/log.hpp"
#include "drivers/illuminator/illuminators.hpp"

#include <algorithm>
#include <chrono>
#include <limits>
#include <string>
#include <utility>

namespace afterglow {
namespace {

constexpr std::int64_t open_end = std::numeric_limits<std::int64_t>::max();

} // namespace

LightSwitch::LightSwitch(std::unique_ptr<Illuminator> light) : light_(std::move(light)) {
    thread_ = std::thread([this] { run(); });
}

LightSwitch::~LightSwitch() {
    give(false, true);
    thread_.join();
}

void LightSwitch::give(bool lit, bool stop) {
    given_.lit = lit;
    given_.stop = stop;
    ++given_.number;
    order_.store(given_, std::memory_order_release);
    order_.notify_one();
}

Status LightSwitch::set(bool lit) {
    take_done();
    if (problem_) {
        const Error error = {std::string(problem_->sentence()), 0};
        problem_.reset();
        return error;
    }
    if (lit == wanted_)
        return ok();
    wanted_ = lit;
    if (lit && spans_[newest_].end_ns != open_end) {
        newest_ = (newest_ + 1) % spans_.size();
        spans_[newest_] = {monotonic_ns(), open_end};
    }
    give(lit, false);
    return ok();
}

bool LightSwitch::lit() const {
    take_done();
    return wanted_;
}

bool LightSwitch::was_lit(std::int64_t t_ns) const {
    take_done();
    return std::any_of(spans_.begin(), spans_.end(), [&](const Span &span) {
        return t_ns >= span.begin_ns && t_ns < span.end_ns;
    });
}

void LightSwitch::take_done() const {
    for (Done done; done_.pop(done);) {
        if (done.number == given_.number) {
            if (done.failed)
                problem_ = done.problem;
            wanted_ = done.lit != done.failed;
        }
        // Dark: switched off, or never on. An order to light that came meanwhile goes on with it.
        if (done.lit == done.failed && !wanted_)
            close_span(done.end_ns);
    }
}

void LightSwitch::close_span(std::int64_t end_ns) const {
    if (spans_[newest_].end_ns == open_end)
        spans_[newest_].end_ns = end_ns;
}

void LightSwitch::run() noexcept {
    bool is_stuck = false; // it was to go dark and did not
    const auto darkened = [&](const Status &status) {
        const bool was_stuck = std::exchange(is_stuck, !status);
        // While no stream is open no later set() would return the error.
        if (is_stuck && !was_stuck)
            log(Priority::error, "the illuminator may still be lit: " + status.error().message);
        else if (was_stuck && !is_stuck)
            log(Priority::info, "the illuminator is dark");
    };
    for (Order seen; true;) {
        const bool ordered = wait_for_order(seen, is_stuck);
        seen = order_.load(std::memory_order_acquire);
        if (seen.stop)
            break;
        if (!ordered) {
            darkened(light_->set(false));
            if (!is_stuck)
                done_.push({false, false, seen.number, monotonic_ns(), {}});
            continue;
        }
        // Answered even when there is nothing to do: an order may have been overtaken by its
        // opposite.
        Done done = {seen.lit, false, seen.number, 0, {}};
        const Status status = light_->lit() == seen.lit ? ok() : light_->set(seen.lit);
        if (!status) {
            done.failed = true;
            done.problem = Note::of(Priority::error, status.error().message);
        }
        if (!seen.lit)
            darkened(status);
        else if (status)
            is_stuck = false;
        else if (const Status out = light_->set(false); // one that reports a failure may have lit
                 out || !is_absent(out.error().code))
            darkened(out);
        done.end_ns = monotonic_ns();
        done_.push(done);
    }
    light_.reset();
}

/// Waits for another order than `seen`; not for ever if the light is stuck. False if none came.
bool LightSwitch::wait_for_order(const Order &seen, bool is_stuck) const {
    constexpr std::chrono::milliseconds look{20}, pause{1000};
    if (!is_stuck) {
        order_.wait(seen, std::memory_order_acquire);
        return true;
    }
    // An atomic cannot be waited for until a certain time.
    for (auto waited = look; waited <= pause; waited += look) {
        std::this_thread::sleep_for(look);
        if (order_.load(std::memory_order_acquire).number != seen.number)
            return true;
    }
    return false;
}

} // namespace afterglow
