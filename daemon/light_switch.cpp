// SPDX-License-Identifier: Apache-2.0
#include "daemon/light_switch.hpp"

#include "core/base/clock.hpp"
#include "core/base/log.hpp"

#include <algorithm>
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
        if (done.failed && done.number == given_.number) {
            problem_ = done.problem;
            wanted_ = !done.lit;
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
    bool is_failure_logged = false;
    for (Order seen; true;) {
        order_.wait(seen, std::memory_order_acquire);
        seen = order_.load(std::memory_order_acquire);
        if (seen.stop)
            break;
        // Answered even when there is nothing to do: an order may have been overtaken by its
        // opposite.
        Done done = {seen.lit, false, seen.number, 0, {}};
        const Status status = light_->lit() == seen.lit ? ok() : light_->set(seen.lit);
        if (!status && seen.lit) // a device that reports a failure may have lit
            static_cast<void>(light_->set(false));
        if (!status) {
            done.failed = true;
            done.problem = Note::of(Priority::error, status.error().message);
        }
        // While no stream is open no later set() would return the error. Logged once, until the
        // light obeys again.
        if (status) {
            is_failure_logged = false;
        } else if (!seen.lit && !is_failure_logged) {
            log(Priority::error, "the illuminator may still be lit: " + status.error().message);
            is_failure_logged = true;
        }
        done.end_ns = monotonic_ns();
        done_.push(done);
    }
    light_.reset();
}

} // namespace afterglow
