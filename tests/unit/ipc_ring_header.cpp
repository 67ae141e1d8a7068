// SPDX-License-Identifier: Apache-2.0
//
// What a reader accepts as a ring, and what it can do to one.
#include "tests/test_ring.hpp"

#include <sys/mman.h>
#include <sys/stat.h>

#include <cerrno>
#include <cmath>
#include <cstring>
#include <functional>
#include <limits>
#include <random>
#include <string>

using namespace afterglow;
using namespace afterglow::test;

namespace {

constexpr int all_seals = F_SEAL_GROW | F_SEAL_SHRINK | F_SEAL_FUTURE_WRITE | F_SEAL_SEAL;

std::vector<unsigned char> bytes_of(const RingWriter &writer) {
    std::vector<unsigned char> bytes(writer.bytes());
    REQUIRE(::pread(writer.fd(), bytes.data(), bytes.size(), 0) ==
            static_cast<ssize_t>(bytes.size()));
    return bytes;
}

UniqueFd memfd_with(const void *bytes, std::size_t size, int seals = all_seals) {
    UniqueFd fd(::memfd_create("test", MFD_CLOEXEC | MFD_ALLOW_SEALING));
    REQUIRE(::pwrite(fd.get(), bytes, size, 0) == static_cast<ssize_t>(size));
    REQUIRE(::fcntl(fd.get(), F_ADD_SEALS, seals) == 0);
    return fd;
}

int open_memory(UniqueFd memory, Stream &stream) {
    int ends[2];
    REQUIRE(::socketpair(AF_UNIX, SOCK_SEQPACKET | SOCK_CLOEXEC, 0, ends) == 0);
    const UniqueFd daemon_end(ends[0]);
    afterglow_stream *opened = nullptr;
    const int error = afterglow_open_fds(memory.release(), ends[1], &opened);
    REQUIRE((error == 0) == (opened != nullptr));
    stream.reset(opened);
    return error;
}

int open_memory(UniqueFd memory) {
    Stream stream;
    return open_memory(std::move(memory), stream);
}

/// What comes of opening a good ring after `change` was made to its header.
int open_changed(const std::function<void(afterglow_ring_header &)> &change) {
    TestRing ring;
    auto bytes = bytes_of(ring.writer());
    afterglow_ring_header header;
    std::memcpy(&header, bytes.data(), sizeof header);
    change(header);
    std::memcpy(bytes.data(), &header, sizeof header);
    return open_memory(memfd_with(bytes.data(), bytes.size()));
}

} // namespace

TEST_CASE("a copy of a valid ring is accepted", "[ipc]") {
    CHECK(open_changed([](afterglow_ring_header &) {}) == 0);
}

TEST_CASE("a ring whose header contradicts itself is refused", "[ipc]") {
    using Header = afterglow_ring_header;
    constexpr auto huge32 = std::numeric_limits<std::uint32_t>::max();
    constexpr auto huge64 = std::numeric_limits<std::uint64_t>::max();
    constexpr auto nan = std::numeric_limits<double>::quiet_NaN();
    struct Lie {
        const char *what;
        std::function<void(Header &)> change;
        int error = -EPROTO;
    };
    const Lie lies[] = {
        {"magic", [](Header &h) { ++h.magic; }},
        {"older major", [](Header &h) { --h.major; }, -EPROTONOSUPPORT},
        {"newer major", [](Header &h) { ++h.major; }, -EPROTONOSUPPORT},
        {"header of nothing", [](Header &h) { h.header_size = 0; }},
        {"header shorter than ours", [](Header &h) { h.header_size -= 64; }},
        {"header not aligned", [](Header &h) { h.header_size += 8; }},
        {"header pushes slots out", [](Header &h) { h.header_size += 64; }},
        {"header longer than memory", [](Header &h) { h.header_size = huge32 - 63; }},
        {"no slots", [](Header &h) { h.slot_count = 0; }},
        {"one slot", [](Header &h) { h.slot_count = 1; }},
        {"a slot too many", [](Header &h) { ++h.slot_count; }},
        {"slots without end", [](Header &h) { h.slot_count = huge32; }},
        {"slots of nothing", [](Header &h) { h.slot_stride = 0; }},
        {"slots not aligned", [](Header &h) { h.slot_stride -= 8; }},
        {"slots too short for planes", [](Header &h) { h.slot_stride -= 64; }},
        {"slots too long", [](Header &h) { h.slot_stride += 64; }},
        {"slots that overflow", [](Header &h) { h.slot_stride = (std::uint64_t{1} << 61) + 64; }},
        {"slots that wrap", [](Header &h) { h.slot_stride = std::uint64_t{1} << 61; }},
        {"slot header of nothing", [](Header &h) { h.slot_header_size = 0; }},
        {"slot header shorter than ours", [](Header &h) { h.slot_header_size -= 8; }},
        {"slot header not aligned", [](Header &h) { h.slot_header_size += 4; }},
        {"slot header over a plane", [](Header &h) { h.slot_header_size += 64; }},
        {"slot header without end", [](Header &h) { h.slot_header_size = huge32 - 7; }},
        {"no planes", [](Header &h) { h.plane_count = 0; }},
        {"an empty plane", [](Header &h) { ++h.plane_count; }},
        {"planes without end", [](Header &h) { h.plane_count = huge32; }},
        {"no depth", [](Header &h) { h.planes[0].kind = 77; }},
        {"two depths", [](Header &h) { h.planes[1] = h.planes[0]; }},
        {"two lumas", [](Header &h) { h.planes[1].kind = AFTERGLOW_PLANE_LUMA; }},
        {"plane without width", [](Header &h) { h.planes[0].width = 0; }},
        {"plane wider than its rows", [](Header &h) { h.planes[0].width += 1; }},
        {"plane without end to the right", [](Header &h) { h.planes[0].width = huge32; }},
        {"plane without height", [](Header &h) { h.planes[2].height = 0; }},
        {"plane higher than its slot", [](Header &h) { h.planes[2].height += 1; }},
        {"plane without end below", [](Header &h) { h.planes[0].height = huge32; }},
        {"rows of nothing", [](Header &h) { h.planes[1].stride_bytes = 0; }},
        {"rows not aligned", [](Header &h) { h.planes[1].stride_bytes += 1; }},
        {"rows too short", [](Header &h) { h.planes[1].stride_bytes -= 8; }},
        {"rows too long", [](Header &h) { h.planes[2].stride_bytes += 8; }},
        {"rows without end", [](Header &h) { h.planes[0].stride_bytes = huge32 - 7; }},
        {"rows of an unknown plane without end",
         [](Header &h) {
             h.planes[1].kind = 77;
             h.planes[1].stride_bytes = huge32 - 7;
         }},
        {"plane over the slot header", [](Header &h) { h.planes[0].offset = 0; }},
        {"plane not aligned", [](Header &h) { h.planes[0].offset += 4; }},
        {"plane beyond its slot", [](Header &h) { h.planes[2].offset += 64; }},
        {"plane that overflows", [](Header &h) { h.planes[0].offset = huge64 - 63; }},
        {"no focal length", [](Header &h) { h.fx = 0; }},
        {"focal length that is no number", [](Header &h) { h.fx = nan; }},
        {"negative focal length", [](Header &h) { h.fy = -h.fy; }},
        {"focal length without end", [](Header &h) { h.fy = 1 / 0.0; }},
        {"principal point that is no number", [](Header &h) { h.cx = nan; }},
        {"principal point without end", [](Header &h) { h.cy = -1 / 0.0; }},
        {"unknown state of the writer", [](Header &h) { h.writer_state = 0; }},
        {"writer that has closed", [](Header &h) { h.writer_state = AFTERGLOW_WRITER_CLOSED; },
         -EPIPE},
    };
    for (const Lie &lie : lies) {
        INFO(lie.what);
        CHECK(open_changed(lie.change) == lie.error);
    }
}

TEST_CASE("a ring of a newer minor version is accepted", "[ipc]") {
    CHECK(open_changed([](afterglow_ring_header &header) {
              ++header.minor;
              header.planes[2].kind = 77;
          }) == 0);
}

TEST_CASE("a ring in unsealed, truncated or other memory is refused", "[ipc]") {
    TestRing ring;
    ring.publish();
    const auto bytes = bytes_of(ring.writer());

    SECTION("unsealed memory") {
        for (const int missing :
             {F_SEAL_GROW, F_SEAL_SHRINK, F_SEAL_FUTURE_WRITE, F_SEAL_SEAL, all_seals}) {
            INFO("without seal " << missing);
            CHECK(open_memory(memfd_with(bytes.data(), bytes.size(), all_seals & ~missing)) ==
                  -EPERM);
        }
    }
    SECTION("truncated memory") {
        for (const std::size_t size :
             {std::size_t{0}, std::size_t{1}, sizeof(afterglow_ring_header) - 1,
              sizeof(afterglow_ring_header), bytes.size() / 2, bytes.size() - 1}) {
            INFO(size << " bytes");
            CHECK(open_memory(memfd_with(bytes.data(), size)) == -EPROTO);
        }
    }
    SECTION("a file that is no memfd") {
        CHECK(open_memory(UniqueFd(::open("/dev/null", O_RDONLY | O_CLOEXEC))) == -EPROTO);
        CHECK(open_memory(UniqueFd(::open("/", O_RDONLY | O_CLOEXEC))) == -EPROTO);
    }
    SECTION("an invalid descriptor") {
        CHECK(open_memory(UniqueFd()) == -EBADF);
    }
}

TEST_CASE("a ring whose socket is no socket is refused and its memory closed", "[ipc]") {
    TestRing ring;
    afterglow_stream *stream = nullptr;
    const int memory = ::fcntl(ring.writer().fd(), F_DUPFD_CLOEXEC, 0);
    CHECK(afterglow_open_fds(memory, ::open("/dev/null", O_RDONLY | O_CLOEXEC), &stream) ==
          -EPROTO);
    CHECK(stream == nullptr);
    CHECK(::fcntl(memory, F_GETFD) == -1);
}

TEST_CASE("a ring with a random header is refused or read without harm", "[ipc]") {
    TestRing ring;
    ring.publish();
    auto bytes = bytes_of(ring.writer());
    const std::vector<unsigned char> good = bytes;
    std::mt19937 random(1);
    int accepted = 0;
    for (int round = 0; round < 4000; ++round) {
        bytes = good;
        // The live part of the header too, and the first slot's.
        for (int changes = 1 + static_cast<int>(random() % 3); changes > 0; --changes)
            bytes[random() % 512] ^= static_cast<unsigned char>(1U << random() % 8);
        Stream stream;
        if (open_memory(memfd_with(bytes.data(), bytes.size()), stream) < 0)
            continue;
        ++accepted;
        Planes planes(stream.get());
        afterglow_frame frame{};
        for (afterglow_buffer &wanted : planes.wanted)
            afterglow_read_latest(stream.get(), &frame, &wanted, 1);
        afterglow_read(stream.get(), 3, &frame, nullptr, 0);
        afterglow_wait(stream.get(), 0);
    }
    CHECK(accepted > 0);
}

TEST_CASE("a reader cannot write to the ring", "[ipc]") {
    TestRing ring;
    ring.publish();
    const int fd = ring.writer().fd();
    const auto size = static_cast<std::size_t>(ring.writer().bytes());
    // What a reader has, and the most it can make of it.
    UniqueFd reopened(::open(("/proc/self/fd/" + std::to_string(fd)).c_str(), O_RDWR | O_CLOEXEC));
    for (const int each : {fd, reopened ? reopened.get() : fd}) {
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
    ring.publish();
    UniqueFd daemon_end;
    const Stream stream = ring.open(daemon_end);
    Planes planes(stream.get());
    CHECK(afterglow_read(stream.get(), 0, nullptr, planes.wanted, 3) == 0);
    CHECK(planes.are_of(0));
}

TEST_CASE("no ring is created for invalid camera parameters", "[ipc]") {
    const Intrinsics good{500, 500, 319.5, 239.5, 640, 480};
    REQUIRE(RingWriter::create(good));
    const auto refused = [&](auto change) {
        Intrinsics camera = good;
        change(camera);
        const auto ring = RingWriter::create(camera);
        return !ring && ring.error().code == EINVAL;
    };
    CHECK(refused([](Intrinsics &camera) { camera.width = 0; }));
    CHECK(refused([](Intrinsics &camera) { camera.height = -480; }));
    CHECK(refused([](Intrinsics &camera) { camera.width = RingWriter::max_side + 1; }));
    CHECK(refused([](Intrinsics &camera) { camera.fx = 0; }));
    CHECK(refused([](Intrinsics &camera) { camera.cy = std::nan(""); }));
}
