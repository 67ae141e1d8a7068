// SPDX-License-Identifier: Apache-2.0
#include "tests/attackers/attack.hpp"

#include <sys/mman.h>
#include <sys/stat.h>
#include <sys/syscall.h>

#include <array>
#include <cerrno>
#include <fcntl.h>
#include <unistd.h>

#ifndef MADV_COLLAPSE // Linux 6.1
#define MADV_COLLAPSE 25
#endif

namespace afterglow::attack {
namespace {

const bool has_noexec_seals = ::access("/proc/sys/vm/memfd_noexec", F_OK) == 0;

void must_fail(bool done, const char *what) {
    if (done)
        say(std::string("broken: ") + what);
}

bool maps_writable(int fd, std::size_t bytes) {
    void *const at = ::mmap(nullptr, bytes, PROT_READ | PROT_WRITE, MAP_SHARED, fd, 0);
    if (at == MAP_FAILED)
        return false;
    ::munmap(at, bytes);
    return true;
}

/// Everything that would change the memory through a descriptor of it.
void tamper(int fd, std::size_t bytes) {
    const std::array<char, 64> junk = {};
    must_fail(maps_writable(fd, bytes), "mapped for writing");
    must_fail(::pwrite(fd, junk.data(), junk.size(), 0) >= 0, "written");
    must_fail(::ftruncate(fd, 0) == 0, "cut off");
    must_fail(::ftruncate(fd, static_cast<off_t>(2 * bytes)) == 0, "extended");
    must_fail(::fallocate(fd, FALLOC_FL_PUNCH_HOLE | FALLOC_FL_KEEP_SIZE, 0,
                          static_cast<off_t>(bytes)) == 0,
              "punched");
    must_fail(::fallocate(fd, FALLOC_FL_ZERO_RANGE, 0, static_cast<off_t>(bytes)) == 0, "zeroed");
    must_fail(::fcntl(fd, F_ADD_SEALS, F_SEAL_WRITE) == 0, "sealed against the writer");
}

/// The same through a new file description, and through its name.
void reopen(const Memory &memory) {
    const std::string path = "/proc/self/fd/" + std::to_string(memory.fd.get());
    for (const int mode : {O_RDONLY, O_WRONLY, O_RDWR, O_RDWR | O_TRUNC})
        if (const UniqueFd fd(::open(path.c_str(), mode | O_CLOEXEC)); fd)
            tamper(fd.get(), memory.bytes);
    must_fail(::truncate(path.c_str(), 0) == 0, "cut off by name");
}

/// It is no program: what refuses it is its seal (Linux 6.3), not that it does not look like one.
void execute(const Memory &memory) {
    must_fail(::fchmod(memory.fd.get(), 0700) == 0 && has_noexec_seals, "made a program");
    char *const nothing[] = {nullptr};
    ::syscall(SYS_execveat, memory.fd.get(), "", nothing, nothing, AT_EMPTY_PATH);
    must_fail(errno != EACCES && has_noexec_seals, "executed");
}

/// What the mapping itself allows.
void advise(const Memory &memory) {
    void *const at = const_cast<std::uint8_t *>(memory.at);
    must_fail(::mprotect(at, memory.bytes, PROT_READ | PROT_WRITE) == 0, "made writable");
    must_fail(::madvise(at, memory.bytes, MADV_REMOVE) == 0, "removed");
    // Allowed, and without consequence for the writer and for other readers.
    for (const int advice : {MADV_DONTNEED, MADV_COLD, MADV_PAGEOUT, MADV_HUGEPAGE, MADV_COLLAPSE})
        ::madvise(at, memory.bytes, advice);
    ::mlock(at, memory.bytes);
    ::munlock(at, memory.bytes);
}

} // namespace

/// Tries to change the memory in every way, over and over.
int vandal(const std::string &from) {
    const UniqueFd socket = open_stream(from);
    const std::vector<Memory> memories = first_memories(socket.get());
    for (bool first = true;; first = false) {
        for (const Memory &memory : memories) {
            tamper(memory.fd.get(), memory.bytes);
            reopen(memory);
            execute(memory);
            advise(memory);
        }
        if (first)
            say("ready");
    }
}

} // namespace afterglow::attack
