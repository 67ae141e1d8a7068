// SPDX-License-Identifier: Apache-2.0
#include "ipc/ring/ring_memory.hpp"

#include "ipc/ring/seqlock.hpp"

#include <fmt/format.h>
#include <linux/memfd.h>
#include <sys/mman.h>

#include <bit>
#include <cassert>
#include <cerrno>
#include <csignal>
#include <cstddef>
#include <cstring>
#include <fcntl.h>
#include <limits>
#include <new>

#ifndef MFD_NOEXEC_SEAL // Linux 6.3
#define MFD_NOEXEC_SEAL 0x0008U
#endif

namespace afterglow {
namespace {

static_assert(std::endian::native == std::endian::little, "the ring is little-endian");
static_assert(sizeof(afterglow_plane) % 8 == 0 && sizeof(afterglow_frame) % 8 == 0 &&
              offsetof(afterglow_slot_header, frame) == 8 &&
              offsetof(afterglow_ring_header, writer_state) == 128);

constexpr std::uint64_t not_in_use = std::numeric_limits<std::uint64_t>::max();

constexpr std::uint64_t aligned(std::uint64_t bytes, std::uint64_t to) {
    return (bytes + to - 1) / to * to;
}

Error failed_to(const char *what) {
    const int code = errno;
    return {fmt::format("cannot {} the frame ring: {}", what, std::strerror(code)), code};
}

/// Memory that cannot be executed either, where the kernel knows how to say so.
UniqueFd make_memfd() {
    UniqueFd fd(::memfd_create("afterglow", MFD_CLOEXEC | MFD_ALLOW_SEALING | MFD_NOEXEC_SEAL));
    if (!fd && errno == EINVAL)
        fd = UniqueFd(::memfd_create("afterglow", MFD_CLOEXEC | MFD_ALLOW_SEALING));
    return fd;
}

/// Another open file description of the same file. Without /proc there is no way to one.
Result<UniqueFd> reopen_read_only(const UniqueFd &fd) {
    char path[32];
    *fmt::format_to(path, "/proc/self/fd/{}", fd.get()) = '\0';
    UniqueFd read_only(::open(path, O_RDONLY | O_CLOEXEC));
    if (!read_only)
        return failed_to(errno == ENOENT ? "open (it needs /proc to do so)" : "open");
    return read_only;
}

/// Everything of the header but the planes.
afterglow_ring_header describe(std::size_t planes, int slots, std::uint64_t generation) {
    afterglow_ring_header header{};
    header.magic = AFTERGLOW_RING_MAGIC;
    header.major = AFTERGLOW_RING_MAJOR;
    header.minor = AFTERGLOW_RING_MINOR;
    header.slot_count = static_cast<std::uint32_t>(slots);
    header.slot_header_size = sizeof(afterglow_slot_header);
    header.frame_size = sizeof(afterglow_frame);
    header.planes_offset = sizeof(afterglow_ring_header);
    header.plane_count = static_cast<std::uint32_t>(planes);
    header.plane_size = sizeof(afterglow_plane);
    header.header_size = static_cast<std::uint32_t>(
        aligned(header.planes_offset + planes * sizeof(afterglow_plane), 64));
    header.generation = generation;
    header.writer_state = AFTERGLOW_WRITER_RUNNING;
    header.first = not_in_use;
    return header;
}

afterglow_plane &plane_of(afterglow_ring_header &header, int number) {
    auto *bytes = reinterpret_cast<unsigned char *>(&header) + header.planes_offset;
    return reinterpret_cast<afterglow_plane *>(bytes)[number];
}

} // namespace

Result<RingMemory> RingMemory::create(int width, int height, std::span<const PlaneFormat> formats,
                                      int slots, std::uint64_t generation) {
    assert(width > 0 && height > 0 && slots >= 2 && slots <= 1024);
    assert(!formats.empty() && formats.size() <= AFTERGLOW_MAX_PLANES);
    afterglow_ring_header header = describe(formats.size(), slots, generation);
    afterglow_plane planes[AFTERGLOW_MAX_PLANES] = {};
    std::uint64_t offset = sizeof(afterglow_slot_header);
    for (std::size_t i = 0; i < formats.size(); ++i) {
        afterglow_plane &plane = planes[i];
        plane.kind = formats[i].kind;
        plane.format = formats[i].format;
        plane.width = static_cast<std::uint32_t>(width);
        plane.height = static_cast<std::uint32_t>(height);
        plane.pixel_bytes = formats[i].pixel_bytes;
        plane.stride_bytes =
            static_cast<std::uint32_t>(aligned(std::uint64_t{plane.width} * plane.pixel_bytes, 8));
        plane.offset = aligned(offset, 64);
        plane.unit = formats[i].unit;
        offset = plane.offset + std::uint64_t{plane.stride_bytes} * plane.height;
    }
    header.slot_stride = aligned(offset, 64);
    const std::uint64_t bytes = header.header_size + header.slot_count * header.slot_stride;
    if (bytes > std::uint64_t{PTRDIFF_MAX})
        return Error{"cannot map a frame ring of that size on this machine", ENOMEM};

    const UniqueFd fd = make_memfd();
    if (!fd)
        return failed_to("create");
    // Reserved and not only sized: running out of memory is an error here, or a SIGBUS later.
    if (::fallocate(fd.get(), 0, 0, static_cast<off_t>(bytes)) < 0)
        return failed_to("find memory for");
    Result<UniqueFd> read_only = reopen_read_only(fd);
    if (!read_only)
        return read_only.error();
    void *memory =
        ::mmap(nullptr, bytes, PROT_READ | PROT_WRITE, MAP_SHARED | MAP_POPULATE, fd.get(), 0);
    if (memory == MAP_FAILED)
        return failed_to("map");
    RingMemory ring(std::move(*read_only), memory, bytes);
    std::memcpy(memory, &header, sizeof header);
    std::memcpy(static_cast<unsigned char *>(memory) + header.planes_offset, planes,
                formats.size() * sizeof *planes);
    // The only writable mapping there will ever be exists now.
    if (::fcntl(fd.get(), F_ADD_SEALS,
                F_SEAL_GROW | F_SEAL_SHRINK | F_SEAL_FUTURE_WRITE | F_SEAL_SEAL) < 0)
        return failed_to("seal");
    // held_by_others() takes a lease for a moment. Who opens the memory through our /proc then
    // makes the kernel send a signal; this one is ignored, the usual SIGIO would kill.
    if (::fcntl(ring.fd_.get(), F_SETSIG, SIGURG) < 0)
        return failed_to("watch");
    return ring;
}

RingMemory::RingMemory(RingMemory &&other) noexcept
    : fd_(std::move(other.fd_)), header_(std::exchange(other.header_, nullptr)),
      bytes_(other.bytes_) {}

Result<UniqueFd> RingMemory::reader_fd() const {
    return reopen_read_only(fd_);
}

bool RingMemory::held_by_others() const {
    // The kernel grants a write lease only while nobody else has the file open; a mapping, or a
    // message that carries a descriptor, counts as well.
    if (::fcntl(fd_.get(), F_SETLEASE, F_WRLCK) < 0)
        return true;
    ::fcntl(fd_.get(), F_SETLEASE, F_UNLCK);
    return false;
}

void RingMemory::begin_at(std::uint64_t index) {
    __atomic_store_n(&header_->head, index, __ATOMIC_RELAXED);
    __atomic_store_n(&header_->first, index, __ATOMIC_RELEASE);
}

afterglow_slot_header &RingMemory::slot(std::uint64_t index) const {
    auto *bytes = reinterpret_cast<unsigned char *>(header_) + header_->header_size +
                  index % header_->slot_count * header_->slot_stride;
    return *reinterpret_cast<afterglow_slot_header *>(bytes);
}

void RingMemory::begin_frame(std::uint64_t index) {
    seqlock::begin_write(slot(index).sequence, index);
}

template <class T>
void RingMemory::store_rows(std::uint64_t index, int number, ImageView<const T> rows, int first) {
    const afterglow_plane &plane = plane_of(*header_, number);
    assert(rows.width() == static_cast<int>(plane.width) && plane.pixel_bytes == sizeof(T));
    assert(first >= 0 && first + rows.height() <= static_cast<int>(plane.height));
    unsigned char *row = reinterpret_cast<unsigned char *>(&slot(index)) + plane.offset +
                         static_cast<std::size_t>(first) * plane.stride_bytes;
    seqlock::begin_stores();
    for (int v = 0; v < rows.height(); ++v, row += plane.stride_bytes)
        seqlock::store(row, rows.row(v), plane.width * sizeof(T));
    seqlock::end_stores();
}

void RingMemory::store_plane(std::uint64_t index, int plane, ImageView<const std::uint8_t> rows,
                             int first) {
    store_rows(index, plane, rows, first);
}

void RingMemory::store_plane(std::uint64_t index, int plane, ImageView<const std::uint16_t> rows,
                             int first) {
    store_rows(index, plane, rows, first);
}

void RingMemory::end_frame(const afterglow_frame &frame) {
    afterglow_slot_header &written = slot(frame.index);
    seqlock::store(&written.frame, &frame, sizeof frame);
    seqlock::end_write(written.sequence, frame.index);
    __atomic_store_n(&header_->head, frame.index + 1, __ATOMIC_RELEASE);
}

void RingMemory::clear() {
    for (std::uint32_t i = 0; i < header_->slot_count; ++i)
        if (slot(i).sequence != 0)
            seqlock::clear(slot(i).sequence, header_->slot_stride);
    if (header_->first != not_in_use)
        __atomic_store_n(&header_->first, header_->head, __ATOMIC_RELEASE);
}

void RingMemory::set_state(afterglow_writer_state state) {
    __atomic_store_n(&header_->writer_state, state, __ATOMIC_RELEASE);
}

void RingMemory::unmap() {
    if (header_ != nullptr)
        ::munmap(std::exchange(header_, nullptr), bytes_);
}

} // namespace afterglow
