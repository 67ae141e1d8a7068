// SPDX-License-Identifier: Apache-2.0
//
// What a frame costs the estimator thread, with and without clients.
#include "tests/allocation_count.hpp"
#include "tests/sanitized.hpp"
#include "tests/test_ring.hpp"

#include <linux/audit.h>
#include <linux/filter.h>
#include <linux/seccomp.h>
#include <sys/mman.h>
#include <sys/prctl.h>
#include <sys/syscall.h>
#include <sys/wait.h>

#include <csignal>
#include <cstddef>
#include <iterator>
#include <unistd.h>
#include <vector>

using namespace afterglow;
using namespace afterglow::test;

#ifndef AFTERGLOW_SANITIZED

namespace {

struct Calls {
    int writes = 0;
    int others = 0;
};
Calls *counted = nullptr; ///< in memory shared with the test

void count_call(int /*signal*/, siginfo_t *info, void * /*context*/) {
    ++(info->si_syscall == SYS_write ? counted->writes : counted->others);
}

/// From now on this process's system calls are counted instead of made. Reading the clock is one
/// only on machines whose clock the kernel cannot lend to programs.
bool count_system_calls() {
    struct sigaction action = {};
    action.sa_sigaction = count_call;
    action.sa_flags = SA_SIGINFO;
    sock_filter rules[] = {
        BPF_STMT(BPF_LD | BPF_W | BPF_ABS, offsetof(seccomp_data, nr)),
        BPF_JUMP(BPF_JMP | BPF_JEQ | BPF_K, SYS_rt_sigreturn, 3, 0),
        BPF_JUMP(BPF_JMP | BPF_JEQ | BPF_K, SYS_exit_group, 2, 0),
        BPF_JUMP(BPF_JMP | BPF_JEQ | BPF_K, SYS_clock_gettime, 1, 0),
        BPF_STMT(BPF_RET | BPF_K, SECCOMP_RET_TRAP),
        BPF_STMT(BPF_RET | BPF_K, SECCOMP_RET_ALLOW),
    };
    const sock_fprog program = {static_cast<unsigned short>(std::size(rules)), rules};
    return ::sigaction(SIGSYS, &action, nullptr) == 0 &&
           ::prctl(PR_SET_NO_NEW_PRIVS, 1, 0, 0, 0) == 0 &&
           ::prctl(PR_SET_SECCOMP, SECCOMP_MODE_FILTER, &program) == 0;
}

/// The system calls of `frames` frames that are published to a ring's streams as they are now.
Calls calls_of(TestRing &ring, int frames) {
    counted = static_cast<Calls *>(
        ::mmap(nullptr, sizeof(Calls), PROT_READ | PROT_WRITE, MAP_SHARED | MAP_ANONYMOUS, -1, 0));
    REQUIRE(counted != MAP_FAILED);
    const pid_t child = ::fork();
    if (child == 0) {
        if (!count_system_calls())
            ::_exit(1);
        for (int i = 0; i < frames; ++i)
            ring.publish();
        ::_exit(0);
    }
    int status = -1;
    REQUIRE(::waitpid(child, &status, 0) == child);
    CHECK(WIFEXITED(status));
    CHECK(WEXITSTATUS(status) == 0);
    const Calls calls = *counted;
    ::munmap(counted, sizeof(Calls));
    return calls;
}

} // namespace

TEST_CASE("a frame is one system call, whatever clients there are", "[ipc]") {
    TestRing ring;
    const Calls alone = calls_of(ring, 50);
    CHECK(alone.writes == 50);
    CHECK(alone.others == 0);

    // None of them reads, so that all their sockets are full.
    std::vector<UniqueFd> streams;
    for (uid_t user = 1; user <= StreamNotifier::most_streams; ++user) {
        auto stream = ring.streams().open(user, {.images = true});
        REQUIRE(stream);
        streams.push_back(std::move(*stream));
    }
    const Calls crowded = calls_of(ring, 50);
    CHECK(crowded.writes == 50);
    CHECK(crowded.others == 0);

    // Nor does a new memory cost one.
    REQUIRE(ring.writer().renew(true));
    const Calls renewed = calls_of(ring, 50);
    CHECK(renewed.writes == 50);
    CHECK(renewed.others == 0);
}

#endif

TEST_CASE("publishing a ring frame allocates nothing", "[ipc]") {
    TestRing ring;
    const Stream stream = ring.open();
    ring.publish();
    REQUIRE(afterglow_wait(stream.get(), 60'000) == 0);
    // Of this thread alone: the notifier's thread allocates when it sends a stream its new memory.
    const auto allocations_of = [&](int frames) {
        const std::uint64_t before = thread_allocation_count();
        for (int i = 0; i < frames; ++i)
            ring.write();
        return thread_allocation_count() - before;
    };
    CHECK(allocations_of(20) == 0);
    REQUIRE(ring.writer().renew(true));
    CHECK(allocations_of(20) == 0);
    const std::uint64_t before = thread_allocation_count();
    ::operator delete(::operator new(1)); // the counter counts
    CHECK(thread_allocation_count() == before + 1);
}
