// SPDX-License-Identifier: Apache-2.0
#include "ipc/reader/ring_view.hpp"

#include "ipc/seqlock.hpp"

#include <sys/mman.h>
#include <sys/stat.h>

#include <algorithm>
#include <bit>
#include <cerrno>
#include <cmath>
#include <cstddef>
#include <cstring>
#include <fcntl.h>
#include <limits>
#include <span>

namespace afterglow {
namespace {

static_assert(std::endian::native == std::endian::little, "the ring is little-endian");
static_assert(sizeof(afterglow_plane) == 24 && sizeof(afterglow_frame) == 112 &&
              sizeof(afterglow_slot_header) == 120 && sizeof(afterglow_ring_header) == 384 &&
              offsetof(afterglow_ring_header, writer_state) == 320);

/// Without the first three, another reader could write to the memory, or cut it off under us.
constexpr int needed_seals = F_SEAL_FUTURE_WRITE | F_SEAL_SHRINK | F_SEAL_GROW | F_SEAL_SEAL;

std::span<const afterglow_plane> planes(const afterglow_ring_header &header) {
    return {header.planes, header.plane_count};
}

bool fits(const afterglow_plane &plane, const afterglow_ring_header &header) {
    std::uint64_t bytes = 0;
    std::uint64_t end = 0;
    return plane.width > 0 && plane.height > 0 && plane.stride_bytes % 8 == 0 &&
           plane.offset % 8 == 0 && plane.offset >= header.slot_header_size &&
           plane.stride_bytes > 0 && plane.stride_bytes >= RingView::row_bytes(plane) &&
           !__builtin_mul_overflow(std::uint64_t{plane.stride_bytes}, plane.height, &bytes) &&
           !__builtin_add_overflow(plane.offset, bytes, &end) && end <= header.slot_stride;
}

/// Whether each plane lies inside of a slot, is the only one of its kind, and one has depth.
bool planes_fit(const afterglow_ring_header &header) {
    if (header.plane_count < 1 || header.plane_count > AFTERGLOW_MAX_PLANES)
        return false;
    const auto all = planes(header);
    const auto of_kind = [&](std::uint32_t kind) {
        return std::count_if(all.begin(), all.end(),
                             [&](const afterglow_plane &plane) { return plane.kind == kind; });
    };
    return of_kind(AFTERGLOW_PLANE_DEPTH) == 1 &&
           std::all_of(all.begin(), all.end(), [&](const afterglow_plane &plane) {
               return fits(plane, header) && of_kind(plane.kind) == 1;
           });
}

bool slots_fit(const afterglow_ring_header &header, std::uint64_t size) {
    std::uint64_t slots = 0;
    std::uint64_t end = 0;
    return header.header_size >= sizeof header && header.header_size % 64 == 0 &&
           header.slot_header_size >= sizeof(afterglow_slot_header) &&
           header.slot_header_size % 8 == 0 && header.slot_count >= 2 &&
           header.slot_stride % 64 == 0 && header.slot_stride >= header.slot_header_size &&
           !__builtin_mul_overflow(header.slot_stride, std::uint64_t{header.slot_count}, &slots) &&
           !__builtin_add_overflow(slots, std::uint64_t{header.header_size}, &end) && end <= size;
}

bool is_camera(const afterglow_ring_header &header) {
    return std::isfinite(header.fx) && header.fx > 0 && std::isfinite(header.fy) && header.fy > 0 &&
           std::isfinite(header.cx) && std::isfinite(header.cy);
}

int check(const afterglow_ring_header &header, std::uint64_t size) {
    if (header.magic != AFTERGLOW_RING_MAGIC)
        return -EPROTO;
    if (header.major != AFTERGLOW_RING_MAJOR)
        return -EPROTONOSUPPORT;
    const bool known_state = header.writer_state == AFTERGLOW_WRITER_RUNNING ||
                             header.writer_state == AFTERGLOW_WRITER_CLOSED;
    return slots_fit(header, size) && planes_fit(header) && is_camera(header) && known_state
               ? 0
               : -EPROTO;
}

} // namespace

int RingView::open(int memfd, RingView &view) {
    const int seals = ::fcntl(memfd, F_GET_SEALS);
    if (seals < 0)
        return errno == EINVAL ? -EPROTO : -errno; // EINVAL: not a memfd
    if ((seals & needed_seals) != needed_seals)
        return -EPERM;
    struct stat status {};
    if (::fstat(memfd, &status) < 0)
        return -errno;
    const auto size = static_cast<std::uint64_t>(status.st_size);
    if (size < sizeof(afterglow_ring_header) || size > std::numeric_limits<std::size_t>::max())
        return -EPROTO;
    void *memory = ::mmap(nullptr, static_cast<std::size_t>(size), PROT_READ, MAP_SHARED, memfd, 0);
    if (memory == MAP_FAILED)
        return -errno;

    RingView mapped;
    mapped.memory_ = memory;
    mapped.size_ = static_cast<std::size_t>(size);
    seqlock::load(&mapped.header_, memory, sizeof mapped.header_);
    if (const int error = check(mapped.header_, size); error < 0)
        return error;
    view = std::move(mapped);
    return 0;
}

RingView &RingView::operator=(RingView &&other) noexcept {
    std::swap(memory_, other.memory_);
    std::swap(size_, other.size_);
    std::swap(header_, other.header_);
    return *this;
}

RingView::~RingView() {
    if (memory_ != nullptr)
        ::munmap(const_cast<void *>(memory_), size_);
}

const afterglow_plane *RingView::plane(std::uint32_t kind) const {
    const auto all = planes(header_);
    const auto found = std::find_if(
        all.begin(), all.end(), [&](const afterglow_plane &plane) { return plane.kind == kind; });
    return found != all.end() && row_bytes(*found) > 0 ? &*found : nullptr;
}

std::uint64_t RingView::row_bytes(const afterglow_plane &plane) {
    switch (plane.kind) {
    case AFTERGLOW_PLANE_DEPTH:
        return std::uint64_t{2} * plane.width;
    case AFTERGLOW_PLANE_CONFIDENCE:
    case AFTERGLOW_PLANE_LUMA:
        return plane.width;
    default:
        return 0;
    }
}

std::uint64_t RingView::head() const {
    return __atomic_load_n(&live().head, __ATOMIC_ACQUIRE);
}

bool RingView::closed() const {
    return __atomic_load_n(&live().writer_state, __ATOMIC_ACQUIRE) != AFTERGLOW_WRITER_RUNNING;
}

const std::uint32_t *RingView::futex() const {
    return &live().futex;
}

Copied RingView::copy(std::uint64_t index, afterglow_frame &frame, const afterglow_buffer *buffers,
                      std::size_t buffer_count) const {
    const auto *bytes = static_cast<const unsigned char *>(memory_) + header_.header_size +
                        index % header_.slot_count * header_.slot_stride;
    const auto &slot = *reinterpret_cast<const afterglow_slot_header *>(bytes);

    const std::uint64_t sequence = seqlock::begin_read(slot.sequence);
    if (sequence != seqlock::complete(index))
        return sequence > seqlock::complete(index) ? Copied::overwritten : Copied::incomplete;
    seqlock::load(&frame, &slot.frame, sizeof frame);
    for (const afterglow_buffer &buffer : std::span(buffers, buffer_count)) {
        const afterglow_plane &from = *plane(buffer.kind);
        const auto row = static_cast<std::size_t>(row_bytes(from));
        auto *to = static_cast<unsigned char *>(buffer.data);
        for (std::size_t v = 0; v < from.height; ++v)
            seqlock::load(to + v * row, bytes + from.offset + v * from.stride_bytes, row);
    }
    if (!seqlock::end_read(slot.sequence, sequence))
        return Copied::overwritten;
    return frame.index == index ? Copied::whole : Copied::damaged;
}

} // namespace afterglow
