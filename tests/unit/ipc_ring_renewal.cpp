// SPDX-License-Identifier: Apache-2.0
//
// One memory of a ring after another.
#include "tests/test_ring.hpp"
#include "tests/wait_until.hpp"

#include <sys/mman.h>
#include <sys/uio.h>

#include <atomic>
#include <cerrno>
#include <cstring>
#include <fcntl.h>
#include <thread>

using namespace afterglow;
using namespace afterglow::test;

TEST_CASE("a ring's renewal loses a reader no frame", "[ipc]") {
    TestRing ring(64, 48, 64);
    const Stream stream = ring.open();
    Planes planes(stream.get());
    afterglow_frame frame = empty_frame();
    std::uint64_t next = 0;
    for (int round = 0; round < 20; ++round) {
        for (int i = 0; i < 3; ++i)
            ring.publish();
        const Stream other = ring.open({.images = true}, 2);
        ring.streams().close_if([](const StreamClaim &claim) { return claim.user == 2; }, EACCES);
        for (int i = 0; i < 3; ++i)
            ring.publish();
        for (const std::uint64_t end = next + 6; next < end; ++next) {
            // It may have to wait until the notifier has sent the new memory.
            REQUIRE(wait_until([&] {
                return afterglow_read(stream.get(), next, &frame, planes.wanted, 3) != -EAGAIN;
            }));
            REQUIRE(afterglow_read(stream.get(), next, &frame, planes.wanted, 3) == 0);
            CHECK(frame.index == next);
            CHECK(planes.are_of(next));
        }
    }
    CHECK(ring.writer().renewals() == 20);
    CHECK(afterglow_skipped(stream.get()) == 0);
}

TEST_CASE("a ring that is replaced says from which frame on", "[ipc]") {
    TestRing ring;
    const Result<ReaderFds> before = ring.writer().reader_fds(true);
    ring.publish();
    ring.publish();
    REQUIRE(ring.writer().renew(false));
    const Result<ReaderFds> after = ring.writer().reader_fds(true);
    REQUIRE(before);
    REQUIRE(after);
    const auto header_of = [](const UniqueFd &fd) {
        afterglow_ring_header header = {};
        REQUIRE(::pread(fd.get(), &header, sizeof header, 0) == sizeof header);
        return header;
    };
    CHECK(header_of(before->depth).writer_state == AFTERGLOW_WRITER_RUNNING);
    CHECK(header_of(after->depth).first == UINT64_MAX);
    ring.publish();
    for (const UniqueFd *fd : {&before->depth, &before->images})
        CHECK(header_of(*fd).writer_state == AFTERGLOW_WRITER_REPLACED);
    CHECK(header_of(before->depth).head == 2);
    CHECK(header_of(after->depth).first == 2);
    CHECK(header_of(after->depth).head == 3);
    CHECK(header_of(after->depth).generation == ring.writer().generation());
}

TEST_CASE("readers that keep replaced rings stop voluntary renewals, not forced ones", "[ipc]") {
    TestRing ring;
    std::vector<ReaderFds> kept;
    const auto renew = [&](bool forced) {
        kept.push_back(std::move(*ring.writer().reader_fds(true)));
        const Status renewed = ring.writer().renew(forced);
        ring.publish();
        return renewed;
    };
    for (int i = 0; i < RingWriter::most_pairs_held; ++i)
        REQUIRE(renew(false));
    const Status refused = renew(false);
    REQUIRE(!refused);
    CHECK(refused.error().code == EBUSY);
    CHECK(ring.writer().pairs() == RingWriter::most_pairs_held + 1);
    CHECK(renew(true));
    CHECK(ring.writer().pairs() == RingWriter::most_pairs_held + 2);
    kept.clear();
    ring.writer().collect();
    CHECK(ring.writer().pairs() == 1);
    CHECK(renew(false));
}

TEST_CASE("pages of a ring that somebody keeps in a pipe show no later frame", "[ipc]") {
    // They are neither a mapping nor a descriptor: nothing tells the writer of them.
    TestRing ring(64, 48, 2);
    int ends[2];
    REQUIRE(::pipe2(ends, O_CLOEXEC) == 0);
    const UniqueFd out(ends[0]);
    const UniqueFd in(ends[1]);
    {
        const Result<ReaderFds> fds = ring.writer().reader_fds(false);
        REQUIRE(fds);
        void *memory = ::mmap(nullptr, 4096, PROT_READ, MAP_SHARED, fds->depth.get(), 0);
        REQUIRE(memory != MAP_FAILED);
        iovec pages = {memory, 4096};
        REQUIRE(::vmsplice(in.get(), &pages, 1, 0) == 4096);
        ::munmap(memory, 4096);
    }
    ring.publish();
    REQUIRE(ring.writer().renew(false));
    ring.publish();
    for (int i = 0; i < 5; ++i) { // whatever is used again would be by then
        ring.writer().collect();
        REQUIRE(ring.writer().pairs() == 1);
        REQUIRE(ring.writer().renew(false));
        ring.publish();
    }
    std::vector<unsigned char> page(4096);
    REQUIRE(::read(out.get(), page.data(), page.size()) == 4096);
    afterglow_ring_header header = {};
    std::memcpy(&header, page.data(), sizeof header);
    CHECK(header.head == 1);
    std::uint64_t sequence = 0;
    std::memcpy(&sequence, page.data() + header.header_size, sizeof sequence);
    CHECK(sequence == 2); // of frame 0
}

TEST_CASE("a ring renewed faster than it is used keeps what is in use and the newest", "[ipc]") {
    TestRing ring;
    ring.publish();
    for (int i = 0; i < 2 * RingWriter::most_pairs_held; ++i)
        REQUIRE(ring.writer().renew(false));
    ring.writer().collect();
    CHECK(ring.writer().pairs() == 2);
    const Stream stream = ring.open();
    ring.publish();
    ring.writer().collect();
    CHECK(ring.writer().pairs() == 1);
    Planes planes(stream.get());
    afterglow_frame frame = empty_frame();
    REQUIRE(afterglow_read_latest(stream.get(), &frame, planes.wanted, 3) == 0);
    CHECK(frame.index == 1);
    CHECK(planes.are_of(1));
}

TEST_CASE("renewals while a ring is written and read tear no frame", "[ipc][tsan]") {
    TestRing ring(64, 48, 4);
    const Stream stream = ring.open();
    Planes planes(stream.get());
    std::atomic<bool> stop{false};
    std::thread writer([&] {
        while (!stop)
            ring.publish();
    });
    int whole = 0;
    int torn = 0;
    int refused = 0;
    for (int round = 0; round < 60; ++round) {
        { const Stream other = ring.open({.images = true}, 2); }
        refused += !ring.writer().renew(true);
        const std::uint64_t renewals = ring.writer().renewals();
        // Until it reads from a memory of this round or a later one.
        for (int reads = 0; reads < 50; ++reads) {
            afterglow_frame frame = empty_frame();
            if (afterglow_wait(stream.get(), 60'000) != 0)
                break;
            if (afterglow_read_latest(stream.get(), &frame, planes.wanted, 3) != 0)
                continue;
            ++whole;
            torn += !planes.are_of(frame.index);
        }
        ring.writer().collect();
        CHECK(ring.writer().pairs() <=
              4 + static_cast<std::size_t>(renewals != ring.writer().renewals()));
    }
    stop = true;
    writer.join();
    CHECK(torn == 0);
    CHECK(refused == 0);
    CHECK(whole > 60);
}
