// SPDX-License-Identifier: Apache-2.0
//
// What readers can do with the memory of a ring.
#include "ipc/ring/stream_message.hpp"
#include "tests/catch.hpp"
#include "tests/test_ring.hpp"

#include <linux/memfd.h>
#include <sys/mman.h>
#include <sys/socket.h>
#include <sys/stat.h>

#include <array>
#include <fcntl.h>
#include <string>

using namespace afterglow;
using namespace afterglow::test;

namespace {

constexpr PlaneFormat format = {AFTERGLOW_PLANE_DEPTH, AFTERGLOW_FORMAT_Z16, 2, 0.001};

RingMemory make_memory() {
    return std::move(*RingMemory::create(64, 48, std::span(&format, 1), 2, 1));
}

UniqueFd reader_fd(const RingMemory &memory) {
    return std::move(*memory.reader_fd());
}

UniqueFd reopened(const UniqueFd &fd, int flags) {
    return UniqueFd(
        ::open(("/proc/self/fd/" + std::to_string(fd.get())).c_str(), flags | O_CLOEXEC));
}

} // namespace

TEST_CASE("a reader cannot write to the ring", "[ipc]") {
    TestRing ring;
    const Stream stream = ring.open();
    ring.publish();
    const Result<ReaderFds> fds = ring.writer().reader_fds(true);
    REQUIRE(fds);
    for (const UniqueFd *own : {&fds->depth, &fds->images}) {
        // What a reader has, and the most it can make of it.
        const UniqueFd more = reopened(*own, O_RDWR);
        for (const int each : {own->get(), more ? more.get() : own->get()}) {
            const auto size = static_cast<std::size_t>(::lseek(each, 0, SEEK_END));
            CHECK(::mmap(nullptr, size, PROT_READ | PROT_WRITE, MAP_SHARED, each, 0) == MAP_FAILED);
            CHECK(::pwrite(each, "x", 1, 0) == -1);
            CHECK(::ftruncate(each, 0) == -1);
            CHECK(::ftruncate(each, static_cast<off_t>(2 * size)) == -1);
            CHECK(::fallocate(each, FALLOC_FL_PUNCH_HOLE | FALLOC_FL_KEEP_SIZE, 0, 4096) == -1);
            CHECK(::fcntl(each, F_ADD_SEALS, F_SEAL_WRITE) == -1);
            void *memory = ::mmap(nullptr, size, PROT_READ, MAP_SHARED, each, 0);
            REQUIRE(memory != MAP_FAILED);
            CHECK(::mprotect(memory, size, PROT_READ | PROT_WRITE) == -1);
            CHECK(::madvise(memory, size, MADV_REMOVE) == -1);
            ::munmap(memory, size);
        }
    }
    ring.publish();
    Planes planes(stream.get());
    CHECK(afterglow_read(stream.get(), 0, nullptr, planes.wanted, 3) == 0);
    CHECK(planes.are_of(0));
}

TEST_CASE("the ring's memory cannot be executed", "[ipc]") {
    const UniqueFd fd = reader_fd(make_memory());
    const UniqueFd other(::memfd_create("test", MFD_CLOEXEC | 0x0008U)); // MFD_NOEXEC_SEAL
    if (!other)
        return; // a kernel before 6.3
    constexpr int seal_exec = 0x0020;
    CHECK((::fcntl(fd.get(), F_GET_SEALS) & seal_exec) != 0);
    CHECK(::fchmod(fd.get(), 0700) == -1);
}

TEST_CASE("each reader has a file description of its own", "[ipc]") {
    const RingMemory memory = make_memory();
    const UniqueFd first = reader_fd(memory);
    const UniqueFd second = reader_fd(memory);
    REQUIRE(::lseek(first.get(), 100, SEEK_SET) == 100);
    REQUIRE(::fcntl(first.get(), F_SETFL, O_NONBLOCK | O_APPEND) == 0);
    CHECK(::lseek(second.get(), 0, SEEK_CUR) == 0);
    CHECK((::fcntl(second.get(), F_GETFL) & (O_NONBLOCK | O_APPEND)) == 0);
    CHECK((::fcntl(second.get(), F_GETFL) & O_ACCMODE) == O_RDONLY);
}

TEST_CASE("a ring's memory is known to be held as long as anybody can read it", "[ipc]") {
    const RingMemory memory = make_memory();
    CHECK_FALSE(memory.held_by_others());

    SECTION("by a descriptor") {
        UniqueFd fd = reader_fd(memory);
        CHECK(memory.held_by_others());
        UniqueFd again = reopened(fd, O_RDONLY);
        fd = UniqueFd();
        CHECK(memory.held_by_others());
    }
    SECTION("by a mapping alone") {
        void *mapped = ::mmap(nullptr, 4096, PROT_READ, MAP_SHARED, reader_fd(memory).get(), 0);
        REQUIRE(mapped != MAP_FAILED);
        CHECK(memory.held_by_others());
        ::munmap(mapped, 4096);
    }
    SECTION("by a message that nobody has received") {
        int ends[2];
        REQUIRE(::socketpair(AF_UNIX, SOCK_SEQPACKET | SOCK_CLOEXEC, 0, ends) == 0);
        const std::array<UniqueFd, 2> sockets = {UniqueFd(ends[0]), UniqueFd(ends[1])};
        REQUIRE(send_memory(ends[0], {reader_fd(memory), {}, 0}, 1));
        CHECK(memory.held_by_others());
    }
    SECTION("by a reader that was given it after the writer had unmapped it") {
        RingMemory retired = make_memory();
        const UniqueFd fd = reader_fd(retired);
        retired.unmap();
        CHECK(retired.held_by_others());
    }
    CHECK_FALSE(memory.held_by_others());
}
