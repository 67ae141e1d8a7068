// SPDX-License-Identifier: Apache-2.0
#include "tests/attackers/attack.hpp"

#include <linux/futex.h>
#include <sys/resource.h>
#include <sys/syscall.h>

#include <atomic>
#include <cstdlib>
#include <poll.h>
#include <thread>
#include <unistd.h>

namespace afterglow::attack {
namespace {

/// Waits on the words that the writer changes, 128 times in one call, for ever.
void wait_on_words(const Memory &memory) {
    const auto *words = reinterpret_cast<const std::uint32_t *>(&memory.header().writer_state);
    for (;;) {
        futex_waitv waits[FUTEX_WAITV_MAX] = {};
        for (std::size_t i = 0; i < FUTEX_WAITV_MAX; ++i) {
            const std::uint32_t *word = words + i % 16;
            waits[i] = {__atomic_load_n(word, __ATOMIC_RELAXED),
                        reinterpret_cast<std::uintptr_t>(word), FUTEX_32, 0};
        }
        ::syscall(SYS_futex_waitv, waits, FUTEX_WAITV_MAX, 0, nullptr, CLOCK_MONOTONIC);
        ::usleep(1000); // a frame came meanwhile
    }
}

/// Waits on the socket as often as one call can: each is an entry in the queue that every datagram
/// goes through. Asked for no event, it does not return while the stream lives.
void wait_on_socket(int socket, std::size_t times) {
    std::vector<pollfd> polls(times, pollfd{socket, 0, 0});
    ::poll(polls.data(), polls.size(), -1);
}

} // namespace

/// Thousands wait for everything that can be waited on.
int crowd(const std::string &from) {
    const UniqueFd socket = open_stream(from);
    const std::vector<Memory> memories = first_memories(socket.get());
    rlimit files = {};
    ::getrlimit(RLIMIT_NOFILE, &files);
    files.rlim_cur = files.rlim_max;
    ::setrlimit(RLIMIT_NOFILE, &files);
    const auto times = std::min<std::size_t>(files.rlim_max, 16'384);

    const char *wanted = std::getenv("AFTERGLOW_ATTACK_THREADS");
    const int threads = wanted ? std::atoi(wanted) : 64;
    for (int i = 0; i < threads; ++i)
        std::thread([&, i] {
            i % 2 == 0 ? wait_on_words(memories[0]) : wait_on_socket(socket.get(), times);
        }).detach();
    ::sleep(1);
    say("ready");
    // Every datagram is taken, so that the next one is sent.
    afterglow_message message;
    std::vector<Memory> more;
    while (receive(socket.get(), message, more)) {
    }
    say("ended");
    for (;;)
        ::pause();
}

} // namespace afterglow::attack
