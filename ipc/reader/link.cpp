// SPDX-License-Identifier: Apache-2.0
#include "ipc/reader/link.hpp"

#include "core/base/clock.hpp"

#include <sys/epoll.h>
#include <sys/timerfd.h>

#include <algorithm>
#include <cerrno>

namespace afterglow {
namespace {

constexpr std::uint64_t shortest_pause_us = 100'000;
constexpr std::uint64_t longest_pause_us = 2'000'000;
constexpr std::uint64_t at_once_us = 1;

std::uint64_t now_us() {
    return static_cast<std::uint64_t>(monotonic_ns() / 1000);
}

/// Whether another daemon, or the same one later, may do better.
bool may_pass(int error) {
    switch (error) {
    case -ENOENT:
    case -ECONNREFUSED:
    case -EHOSTUNREACH:
    case -ETIMEDOUT:
    case -EPIPE:
    case -EBUSY:
        return true;
    default:
        return false;
    }
}

} // namespace

int Link::create(const Options &options) {
    options_ = options;
    epoll_ = UniqueFd(::epoll_create1(EPOLL_CLOEXEC));
    timer_ = UniqueFd(::timerfd_create(CLOCK_MONOTONIC, TFD_CLOEXEC | TFD_NONBLOCK));
    if (!epoll_ || !timer_)
        return -errno;
    return watch(timer_.get(), EPOLLIN);
}

int Link::watch(int fd, std::uint32_t events) {
    epoll_event event = {events, {.fd = fd}};
    if (::epoll_ctl(epoll_.get(), EPOLL_CTL_MOD, fd, &event) == 0)
        return 0;
    return ::epoll_ctl(epoll_.get(), EPOLL_CTL_ADD, fd, &event) == 0 ? 0 : -errno;
}

void Link::close() {
    // Closing alone does not: the file is open in a child that the program has forked, too.
    for (const int fd : {socket_.get(), call_.fd()})
        if (fd >= 0)
            ::epoll_ctl(epoll_.get(), EPOLL_CTL_DEL, fd, nullptr);
    call_.cancel();
    socket_ = UniqueFd();
}

void Link::set_timer(std::uint64_t due_us) {
    itimerspec time{};
    time.it_value.tv_sec = static_cast<time_t>(due_us / 1'000'000);
    time.it_value.tv_nsec = static_cast<long>(due_us % 1'000'000 * 1000);
    ::timerfd_settime(timer_.get(), TFD_TIMER_ABSTIME, &time, nullptr);
}

void Link::call() {
    state_ = State::calling;
    due_us_ = now_us() + options_.timeout_us;
    int error = call_.start(options_.bus, options_.stream, !was_open_);
    if (error == 0)
        error = watch_call();
    if (error < 0)
        lose(error);
}

int Link::watch_call() {
    set_timer(std::min(due_us_, call_.deadline_us()));
    const int events = call_.events();
    // POLLIN is EPOLLIN, and so on.
    return events < 0 ? events : watch(call_.fd(), static_cast<std::uint32_t>(events));
}

void Link::adopt(UniqueFd socket) {
    state_ = State::open;
    was_open_ = true;
    socket_ = std::move(socket);
    problem_ = 0;
    lost_us_ = 0;
    set_timer(0);
    if (const int error = watch(socket_.get(), EPOLLIN); error < 0)
        end(error);
}

void Link::end(int error) {
    state_ = State::ended;
    problem_ = error;
    close();
    set_timer(at_once_us); // whoever waits is to find out
}

Link::Event Link::lose(int error) {
    const bool was_open = state_ == State::open;
    if (!options_.reconnect || !may_pass(error)) {
        end(error);
        return {Event::Kind::ended, {}};
    }
    state_ = State::waiting;
    problem_ = error;
    close();
    const std::uint64_t now = now_us();
    if (lost_us_ == 0)
        lost_us_ = now;
    // So the next daemon is found when a quarter more of the time without one has gone by.
    due_us_ = now + std::clamp((now - lost_us_) / 4, shortest_pause_us, longest_pause_us);
    set_timer(due_us_);
    return {was_open ? Event::Kind::lost : Event::Kind::none, {}};
}

Link::Event Link::next() {
    if (state_ == State::waiting && now_us() >= due_us_)
        call();
    if (state_ == State::calling) {
        UniqueFd socket;
        int result = call_.process(socket);
        if (result == -EINPROGRESS)
            result = now_us() < due_us_ ? watch_call() : -ETIMEDOUT;
        if (result == 0 && socket)
            result = check_stream_socket(socket);
        if (result < 0)
            return lose(result);
        if (socket) {
            close();
            adopt(std::move(socket));
        }
    }
    if (state_ == State::ended)
        return {Event::Kind::ended, {}};
    // Bounded: whoever is at the other end could send for ever.
    for (int datagrams = 0; state_ == State::open && datagrams < 1024; ++datagrams) {
        StreamMessage message = receive(socket_);
        switch (message.kind) {
        case StreamMessage::Kind::nothing:
            return {};
        case StreamMessage::Kind::frame:
            break;
        case StreamMessage::Kind::memory:
            return {Event::Kind::memory, std::move(message)};
        case StreamMessage::Kind::end:
            return lose(message.error);
        }
    }
    return {};
}

} // namespace afterglow
