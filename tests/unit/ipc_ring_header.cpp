// SPDX-License-Identifier: Apache-2.0
//
// What a reader accepts as a ring, and what it can do to one.
#include "ipc/ring/stream_message.hpp"
#include "tests/test_ring.hpp"
#include "tests/wait_until.hpp"

#include <linux/sockios.h>
#include <sys/ioctl.h>
#include <sys/mman.h>
#include <sys/socket.h>
#include <sys/stat.h>

#include <cerrno>
#include <cmath>
#include <cstring>
#include <fcntl.h>
#include <functional>
#include <limits>
#include <random>
#include <string>

using namespace afterglow;
using namespace afterglow::test;

namespace {

constexpr int all_seals = F_SEAL_GROW | F_SEAL_SHRINK | F_SEAL_FUTURE_WRITE | F_SEAL_SEAL;

/// The memory of a ring, as a reader sees it.
std::vector<unsigned char> bytes_of(const UniqueFd &memory) {
    struct stat status {};
    REQUIRE(::fstat(memory.get(), &status) == 0);
    std::vector<unsigned char> bytes(static_cast<std::size_t>(status.st_size));
    REQUIRE(::pread(memory.get(), bytes.data(), bytes.size(), 0) ==
            static_cast<ssize_t>(bytes.size()));
    return bytes;
}

UniqueFd memfd_with(const void *bytes, std::size_t size, int seals = all_seals) {
    UniqueFd fd(::memfd_create("test", MFD_CLOEXEC | MFD_ALLOW_SEALING));
    REQUIRE(::pwrite(fd.get(), bytes, size, 0) == static_cast<ssize_t>(size));
    REQUIRE(::fcntl(fd.get(), F_ADD_SEALS, seals) == 0);
    return fd;
}

/// What comes of a stream whose daemon sends these memories.
int open_memory(const ReaderFds &memory, Stream &stream) {
    int ends[2];
    REQUIRE(::socketpair(AF_UNIX, SOCK_SEQPACKET | SOCK_CLOEXEC, 0, ends) == 0);
    const UniqueFd daemon_end(ends[0]);
    REQUIRE(send_memory(ends[0], memory, 1));
    afterglow_stream *opened = nullptr;
    const int error = afterglow_open_fd(ends[1], &opened);
    REQUIRE((error == 0) == (opened != nullptr));
    stream.reset(opened);
    return error;
}

int open_memory(UniqueFd depth, UniqueFd images = UniqueFd()) {
    Stream stream;
    return open_memory({std::move(depth), std::move(images)}, stream);
}

/// What lies before the slots of the memory with depth.
struct Head {
    afterglow_ring_header header;
    afterglow_plane planes[2];
};
static_assert(sizeof(Head) == sizeof(afterglow_ring_header) + 2 * sizeof(afterglow_plane));

/// What comes of opening a good ring after `change` was made to what describes it.
int open_changed(const std::function<void(Head &)> &change) {
    TestRing ring;
    const Result<ReaderFds> fds = ring.writer().reader_fds(false);
    REQUIRE(fds);
    auto bytes = bytes_of(fds->depth);
    Head head;
    std::memcpy(&head, bytes.data(), sizeof head);
    change(head);
    std::memcpy(bytes.data(), &head, sizeof head);
    return open_memory(memfd_with(bytes.data(), bytes.size()));
}

} // namespace

TEST_CASE("a copy of a valid ring is accepted", "[ipc]") {
    CHECK(open_changed([](Head &) {}) == 0);
}

TEST_CASE("a ring whose header contradicts itself is refused", "[ipc]") {
    constexpr auto huge32 = std::numeric_limits<std::uint32_t>::max();
    constexpr auto huge64 = std::numeric_limits<std::uint64_t>::max();
    constexpr auto nan = std::numeric_limits<double>::quiet_NaN();
    struct Lie {
        const char *what;
        std::function<void(afterglow_ring_header &, afterglow_plane *)> change;
        int error = -EPROTO;
    };
    using H = afterglow_ring_header;
    using P = afterglow_plane;
    const Lie lies[] = {
        {"magic", [](H &h, P *) { ++h.magic; }},
        {"older major", [](H &h, P *) { --h.major; }, -EPROTONOSUPPORT},
        {"newer major", [](H &h, P *) { ++h.major; }, -EPROTONOSUPPORT},
        {"header of nothing", [](H &h, P *) { h.header_size = 0; }},
        {"header shorter than its planes", [](H &h, P *) { h.header_size -= 64; }},
        {"header not aligned", [](H &h, P *) { h.header_size += 8; }},
        {"header pushes slots out", [](H &h, P *) { h.header_size += 64; }},
        {"header longer than memory", [](H &h, P *) { h.header_size = huge32 - 63; }},
        {"no slots", [](H &h, P *) { h.slot_count = 0; }},
        {"one slot", [](H &h, P *) { h.slot_count = 1; }},
        {"a slot too many", [](H &h, P *) { ++h.slot_count; }},
        {"slots without end", [](H &h, P *) { h.slot_count = huge32; }},
        {"slots of nothing", [](H &h, P *) { h.slot_stride = 0; }},
        {"slots not aligned", [](H &h, P *) { h.slot_stride -= 8; }},
        {"slots too short for planes", [](H &h, P *) { h.slot_stride -= 64; }},
        {"slots too long", [](H &h, P *) { h.slot_stride += 64; }},
        {"slots that overflow", [](H &h, P *) { h.slot_stride = (std::uint64_t{1} << 61) + 64; }},
        {"slots that wrap", [](H &h, P *) { h.slot_stride = std::uint64_t{1} << 61; }},
        {"slot header of nothing", [](H &h, P *) { h.slot_header_size = 0; }},
        {"slot header shorter than its frame", [](H &h, P *) { h.slot_header_size -= 8; }},
        {"slot header not aligned", [](H &h, P *) { h.slot_header_size += 4; }},
        {"slot header over a plane", [](H &h, P *) { h.slot_header_size += 64; }},
        {"slot header without end", [](H &h, P *) { h.slot_header_size = huge32 - 7; }},
        {"frame of nothing", [](H &h, P *) { h.frame_size = 0; }},
        {"frame shorter than the first version's", [](H &h, P *) { h.frame_size = 320; }},
        {"frame not aligned", [](H &h, P *) { h.frame_size += 4; }},
        {"frame without end", [](H &h, P *) { h.frame_size = huge32 - 7; }},
        {"planes in the header", [](H &h, P *) { h.planes_offset = 128; }},
        {"planes not aligned", [](H &h, P *) { h.planes_offset += 4; }},
        {"planes behind the header", [](H &h, P *) { h.planes_offset = 264; }},
        {"planes far behind the header", [](H &h, P *) { h.planes_offset = huge32 - 7; }},
        {"planes of nothing", [](H &h, P *) { h.plane_size = 0; }},
        {"planes shorter than the first version's", [](H &h, P *) { h.plane_size -= 8; }},
        {"planes longer than the header", [](H &h, P *) { h.plane_size = 72; }},
        {"planes of any length", [](H &h, P *) { h.plane_size = huge32 - 7; }},
        {"no planes", [](H &h, P *) { h.plane_count = 0; }},
        {"planes without end", [](H &h, P *) { h.plane_count = huge32; }},
        {"no depth", [](H &, P *p) { p[0].kind = 77; }},
        {"two depths", [](H &, P *p) { p[1] = p[0]; }},
        {"planes of two sizes", [](H &, P *p) { p[1].height -= 1; }},
        {"depth without a unit", [](H &, P *p) { p[0].unit = 0; }},
        {"depth in units that are no number", [](H &, P *p) { p[0].unit = nan; }},
        {"depth in negative units", [](H &, P *p) { p[0].unit = -1; }},
        {"plane without width", [](H &, P *p) { p[0].width = 0; }},
        {"plane wider than its rows", [](H &, P *p) { p[0].width += 1; }},
        {"plane without end to the right", [](H &, P *p) { p[0].width = huge32; }},
        {"plane without height", [](H &, P *p) { p[1].height = 0; }},
        {"plane higher than its slot", [](H &, P *p) { p[1].height += 1; }},
        {"plane without end below", [](H &, P *p) { p[0].height = huge32; }},
        {"pixels of nothing", [](H &, P *p) { p[0].pixel_bytes = 0; }},
        {"pixels of another size than their format", [](H &, P *p) { p[0].pixel_bytes = 1; }},
        {"pixels without end",
         [](H &, P *p) {
             p[0].format = 77;
             p[0].pixel_bytes = huge32;
         }},
        {"rows of nothing", [](H &, P *p) { p[1].stride_bytes = 0; }},
        {"rows not aligned", [](H &, P *p) { p[1].stride_bytes += 1; }},
        {"rows too short", [](H &, P *p) { p[1].stride_bytes -= 8; }},
        {"rows too long", [](H &, P *p) { p[1].stride_bytes += 8; }},
        {"rows without end", [](H &, P *p) { p[0].stride_bytes = huge32 - 7; }},
        {"plane over the slot header", [](H &, P *p) { p[0].offset = 0; }},
        {"plane not aligned", [](H &, P *p) { p[0].offset += 4; }},
        {"plane beyond its slot", [](H &, P *p) { p[1].offset += 64; }},
        {"plane that overflows", [](H &, P *p) { p[0].offset = huge64 - 63; }},
        {"unknown state of the writer", [](H &h, P *) { h.writer_state = 0; }},
        {"writer that has closed", [](H &h, P *) { h.writer_state = AFTERGLOW_WRITER_CLOSED; },
         -EPIPE},
    };
    for (const Lie &lie : lies) {
        INFO(lie.what);
        CHECK(open_changed([&](Head &head) { lie.change(head.header, head.planes); }) == lie.error);
    }
}

TEST_CASE("planes that a reader does not know are left alone", "[ipc]") {
    CHECK(open_changed([](Head &head) {
              ++head.header.minor;
              head.planes[1].kind = 77;
          }) == 0);
    CHECK(open_changed([](Head &head) {
              head.planes[1] = {};
              head.planes[1].kind = 77;
              head.planes[1].offset = 1;
          }) == 0);
}

TEST_CASE("memories that do not belong together are refused", "[ipc]") {
    TestRing ring;
    TestRing other;
    TestRing smaller(32, 48);
    const auto fds = [](TestRing &of) { return std::move(*of.writer().reader_fds(true)); };
    CHECK(open_memory(fds(ring).depth, fds(ring).images) == 0);
    CHECK(open_memory(fds(ring).depth, fds(other).images) == -EPROTO);
    CHECK(open_memory(fds(ring).depth, fds(smaller).images) == -EPROTO);
    CHECK(open_memory(fds(ring).depth, fds(ring).depth) == -EPROTO);
    CHECK(open_memory(fds(ring).images) == -EPROTO);
}

TEST_CASE("a ring in unsealed, truncated or other memory is refused", "[ipc]") {
    TestRing ring;
    ring.publish();
    const auto bytes = bytes_of(ring.writer().reader_fds(false)->depth);

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
}

TEST_CASE("what is no stream's socket is refused and closed", "[ipc]") {
    afterglow_stream *stream = nullptr;
    const int file = ::open("/dev/null", O_RDONLY | O_CLOEXEC);
    CHECK(afterglow_open_fd(file, &stream) == -EPROTO);
    CHECK(::fcntl(file, F_GETFD) == -1);
    CHECK(afterglow_open_fd(-1, &stream) == -EBADF);

    const auto ends_of = [](int type) {
        int ends[2];
        REQUIRE(::socketpair(AF_UNIX, type | SOCK_CLOEXEC, 0, ends) == 0);
        return std::pair(UniqueFd(ends[0]), UniqueFd(ends[1]));
    };
    auto bytes = ends_of(SOCK_STREAM);
    CHECK(afterglow_open_fd(bytes.second.release(), &stream) == -EPROTO);
    auto silent = ends_of(SOCK_SEQPACKET);
    CHECK(afterglow_open_fd(silent.second.release(), &stream) == -EPROTO);
    auto dead = ends_of(SOCK_SEQPACKET);
    dead.first = UniqueFd();
    auto empty = ends_of(SOCK_SEQPACKET);
    const afterglow_message without = {AFTERGLOW_MESSAGE_MEMORY, sizeof without, 1};
    REQUIRE(::send(empty.first.get(), &without, sizeof without, 0) == sizeof without);
    CHECK(afterglow_open_fd(empty.second.release(), &stream) == -EPROTO);
    auto ended = ends_of(SOCK_SEQPACKET);
    REQUIRE(send_end(ended.first.get(), EACCES));
    CHECK(afterglow_open_fd(ended.second.release(), &stream) == -EACCES);
    CHECK(stream == nullptr);
}

TEST_CASE("messages that a reader does not know are skipped", "[ipc]") {
    TestRing ring;
    int ends[2];
    REQUIRE(::socketpair(AF_UNIX, SOCK_SEQPACKET | SOCK_CLOEXEC, 0, ends) == 0);
    const UniqueFd daemon_end(ends[0]);
    struct {
        afterglow_message message = {77, sizeof(afterglow_message) + 8, 1};
        std::uint64_t more = 1;
    } newer;
    REQUIRE(::send(ends[0], &newer, sizeof newer, 0) == sizeof newer);
    REQUIRE(::send(ends[0], "short", 5, 0) == 5);
    REQUIRE(send_memory(ends[0], *ring.writer().reader_fds(false), 1));
    afterglow_stream *opened = nullptr;
    REQUIRE(afterglow_open_fd(ends[1], &opened) == 0);
    const Stream stream(opened);
    newer.message.type = AFTERGLOW_MESSAGE_FRAME;
    ring.write();
    REQUIRE(::send(ends[0], &newer, sizeof newer, 0) == sizeof newer);
    CHECK(afterglow_wait(stream.get(), 0) == 0);
}

TEST_CASE("a stream ends when its daemon sends a memory of other planes", "[ipc]") {
    TestRing ring;
    TestRing larger(64, 64);
    int ends[2];
    REQUIRE(::socketpair(AF_UNIX, SOCK_SEQPACKET | SOCK_CLOEXEC, 0, ends) == 0);
    const UniqueFd daemon_end(ends[0]);
    REQUIRE(send_memory(ends[0], *ring.writer().reader_fds(false), 1));
    afterglow_stream *opened = nullptr;
    REQUIRE(afterglow_open_fd(ends[1], &opened) == 0);
    const Stream stream(opened);
    REQUIRE(send_memory(ends[0], *larger.writer().reader_fds(false), 1));
    larger.write();
    Planes planes(stream.get());
    CHECK(afterglow_read_latest(stream.get(), nullptr, planes.wanted, 2) == -EPROTO);
    CHECK(afterglow_wait(stream.get(), -1) == -EPROTO);
}

TEST_CASE("a daemon that sends memory upon memory does not hold a reader", "[ipc]") {
    TestRing ring;
    const ReaderFds memory = *ring.writer().reader_fds(false);
    int ends[2];
    REQUIRE(::socketpair(AF_UNIX, SOCK_SEQPACKET | SOCK_CLOEXEC, 0, ends) == 0);
    const UniqueFd daemon_end(ends[0]);
    REQUIRE(send_memory(ends[0], memory, 1));
    afterglow_stream *opened = nullptr;
    REQUIRE(afterglow_open_fd(ends[1], &opened) == 0);
    const Stream stream(opened);
    for (int i = 0; i < 100; ++i)
        REQUIRE(send_memory(ends[0], memory, 1));
    const auto unread = [&] {
        int bytes = 0;
        REQUIRE(::ioctl(ends[0], SIOCOUTQ, &bytes) == 0);
        return bytes;
    };
    const int sent = unread();
    CHECK(afterglow_wait(stream.get(), 0) == -ETIMEDOUT);
    CHECK(unread() > sent / 2);
    // Frames that come meanwhile are found all the same.
    ring.write();
    REQUIRE(wait_until([&] { return afterglow_wait(stream.get(), 0) == 0; }));
    CHECK(afterglow_read_latest(stream.get(), nullptr, nullptr, 0) == 0);
}

TEST_CASE("a ring with a random header is refused or read without harm", "[ipc]") {
    TestRing ring;
    ring.writer().want_images(true);
    ring.publish();
    const Result<ReaderFds> fds = ring.writer().reader_fds(true);
    REQUIRE(fds);
    const std::vector<unsigned char> good[] = {bytes_of(fds->depth), bytes_of(fds->images)};
    std::mt19937 random(1);
    int accepted = 0;
    for (int round = 0; round < 4000; ++round) {
        auto depth = good[0];
        auto images = good[1];
        // The live part of the header too, and the first slot's.
        for (int changes = 1 + static_cast<int>(random() % 3); changes > 0; --changes)
            (random() % 4 == 0 ? images : depth)[random() % 704] ^=
                static_cast<unsigned char>(1U << random() % 8);
        Stream stream;
        if (open_memory(
                {memfd_with(depth.data(), depth.size()), memfd_with(images.data(), images.size())},
                stream) < 0)
            continue;
        ++accepted;
        Planes planes(stream.get());
        afterglow_frame frame = empty_frame();
        for (afterglow_buffer &wanted : planes.wanted)
            afterglow_read_latest(stream.get(), &frame, &wanted, 1);
        afterglow_read(stream.get(), 0, &frame, planes.wanted, planes.count);
        afterglow_view view = {AFTERGLOW_PLANE_LUMA, 0, nullptr};
        afterglow_peek(stream.get(), &frame, &view, 1);
        afterglow_wait(stream.get(), 0);
    }
    CHECK(accepted > 0);
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
