// SPDX-License-Identifier: Apache-2.0
#include "ipc/reader/ring_view.hpp"

#include "ipc/reader/first_version.hpp"
#include "ipc/ring/seqlock.hpp"

#include <sys/mman.h>
#include <sys/stat.h>

#include <algorithm>
#include <bit>
#include <cerrno>
#include <cmath>
#include <fcntl.h>
#include <limits>

namespace afterglow {
namespace {

static_assert(std::endian::native == std::endian::little, "the ring is little-endian");

/// Without the first three, another reader could write to the memory, or cut it off under us.
constexpr int needed_seals = F_SEAL_FUTURE_WRITE | F_SEAL_SHRINK | F_SEAL_GROW | F_SEAL_SEAL;

bool is_known(const afterglow_plane &plane) {
    return plane.kind == AFTERGLOW_PLANE_DEPTH || plane.kind == AFTERGLOW_PLANE_CONFIDENCE ||
           plane.kind == AFTERGLOW_PLANE_LUMA;
}

/// A format that this library does not know may have pixels of any size.
bool pixels_fit(const afterglow_plane &plane) {
    switch (plane.format) {
    case AFTERGLOW_FORMAT_Z16:
        return plane.pixel_bytes == 2;
    case AFTERGLOW_FORMAT_GREY:
        return plane.pixel_bytes == 1;
    default:
        return plane.pixel_bytes > 0;
    }
}

/// Whether the plane lies inside of a slot.
bool fits(const afterglow_plane &plane, const afterglow_ring_header &header) {
    std::uint64_t row = 0;
    std::uint64_t bytes = 0;
    std::uint64_t end = 0;
    return plane.width > 0 && plane.height > 0 && pixels_fit(plane) &&
           plane.stride_bytes % 8 == 0 && plane.offset % 8 == 0 &&
           plane.offset >= header.slot_header_size &&
           !__builtin_mul_overflow(std::uint64_t{plane.width}, plane.pixel_bytes, &row) &&
           plane.stride_bytes >= row &&
           !__builtin_mul_overflow(std::uint64_t{plane.stride_bytes}, plane.height, &bytes) &&
           !__builtin_add_overflow(plane.offset, bytes, &end) && end <= header.slot_stride &&
           std::isfinite(plane.unit) && plane.unit >= 0;
}

bool slots_fit(const afterglow_ring_header &header, std::uint64_t size) {
    std::uint64_t slots = 0;
    std::uint64_t end = 0;
    return header.header_size % 64 == 0 && header.frame_size >= first_version::frame_size &&
           header.frame_size % 8 == 0 && header.slot_header_size % 8 == 0 &&
           header.slot_header_size >= sizeof(std::uint64_t) &&
           header.slot_header_size - sizeof(std::uint64_t) >= header.frame_size &&
           header.slot_count >= 2 && header.slot_stride % 64 == 0 &&
           header.slot_stride >= header.slot_header_size &&
           !__builtin_mul_overflow(header.slot_stride, std::uint64_t{header.slot_count}, &slots) &&
           !__builtin_add_overflow(slots, std::uint64_t{header.header_size}, &end) && end <= size;
}

bool plane_table_fits(const afterglow_ring_header &header) {
    // Neither product nor sum of 32-bit numbers overflows.
    return header.planes_offset >= first_version::header_size && header.planes_offset % 8 == 0 &&
           header.plane_size >= first_version::plane_size && header.plane_size % 8 == 0 &&
           header.plane_count >= 1 &&
           header.planes_offset + std::uint64_t{header.plane_size} * header.plane_count <=
               header.header_size;
}

bool is_state(std::uint32_t state) {
    return state == AFTERGLOW_WRITER_RUNNING || state == AFTERGLOW_WRITER_CLOSED ||
           state == AFTERGLOW_WRITER_REPLACED;
}

} // namespace

int RingView::open(const UniqueFd &memfd, RingView &view) {
    const int seals = ::fcntl(memfd.get(), F_GET_SEALS);
    if (seals < 0)
        return errno == EINVAL ? -EPROTO : -errno; // EINVAL: not a memfd
    if ((seals & needed_seals) != needed_seals)
        return -EPERM;
    struct stat status {};
    if (::fstat(memfd.get(), &status) < 0)
        return -errno;
    const auto size = static_cast<std::uint64_t>(status.st_size);
    if (size < first_version::header_size || size > std::numeric_limits<std::size_t>::max())
        return -EPROTO;
    void *memory =
        ::mmap(nullptr, static_cast<std::size_t>(size), PROT_READ, MAP_SHARED, memfd.get(), 0);
    if (memory == MAP_FAILED)
        return -errno;

    RingView mapped;
    mapped.memory_ = memory;
    mapped.size_ = static_cast<std::size_t>(size);
    if (const int error = mapped.read_header(); error < 0)
        return error;
    if (const int error = mapped.read_planes(); error < 0)
        return error;
    view = std::move(mapped);
    return 0;
}

int RingView::read_header() {
    seqlock::load(&header_, memory_, first_version::header_size);
    if (header_.magic != AFTERGLOW_RING_MAGIC)
        return -EPROTO;
    if (header_.major != AFTERGLOW_RING_MAJOR)
        return -EPROTONOSUPPORT;
    if (!slots_fit(header_, size_) || !plane_table_fits(header_) || !is_state(header_.writer_state))
        return -EPROTO;
    // What later versions have added, as far as writer and reader both know it.
    constexpr std::size_t known = first_version::header_size;
    const std::size_t more = std::min<std::size_t>(sizeof header_, header_.planes_offset) - known;
    seqlock::load(reinterpret_cast<unsigned char *>(&header_) + known,
                  static_cast<const unsigned char *>(memory_) + known, more);
    return 0;
}

int RingView::read_planes() {
    const auto *table = static_cast<const unsigned char *>(memory_) + header_.planes_offset;
    const std::size_t listed = std::min<std::size_t>(header_.plane_count, AFTERGLOW_MAX_PLANES);
    for (std::size_t i = 0; i < listed; ++i) {
        afterglow_plane read{};
        seqlock::load(&read, table + i * header_.plane_size,
                      std::min<std::size_t>(sizeof read, header_.plane_size));
        if (fits(read, header_) && plane(read.kind) == nullptr)
            planes_[plane_count_++] = read;
        else if (is_known(read))
            return -EPROTO;
    }
    return 0;
}

RingView &RingView::operator=(RingView &&other) noexcept {
    std::swap(memory_, other.memory_);
    std::swap(size_, other.size_);
    std::swap(header_, other.header_);
    std::swap(planes_, other.planes_);
    std::swap(plane_count_, other.plane_count_);
    return *this;
}

RingView::~RingView() {
    if (memory_ != nullptr)
        ::munmap(const_cast<void *>(memory_), size_);
}

const afterglow_plane *RingView::plane(std::uint32_t kind) const {
    const auto all = planes();
    const auto found = std::find_if(
        all.begin(), all.end(), [&](const afterglow_plane &plane) { return plane.kind == kind; });
    return found != all.end() ? &*found : nullptr;
}

std::uint64_t RingView::head() const {
    return __atomic_load_n(&live().head, __ATOMIC_ACQUIRE);
}

std::uint64_t RingView::first() const {
    return __atomic_load_n(&live().first, __ATOMIC_ACQUIRE);
}

std::uint32_t RingView::writer_state() const {
    return __atomic_load_n(&live().writer_state, __ATOMIC_ACQUIRE);
}

SlotState RingView::begin(std::uint64_t index, SlotReading &slot) const {
    slot.bytes = static_cast<const unsigned char *>(memory_) + header_.header_size +
                 index % header_.slot_count * header_.slot_stride;
    slot.sequence = seqlock::begin_read(*reinterpret_cast<const std::uint64_t *>(slot.bytes));
    if (slot.sequence == seqlock::complete(index))
        return SlotState::whole;
    return slot.sequence > seqlock::complete(index) ? SlotState::overwritten : SlotState::empty;
}

bool RingView::still_whole(const SlotReading &slot) {
    return seqlock::end_read(*reinterpret_cast<const std::uint64_t *>(slot.bytes), slot.sequence);
}

void RingView::copy_frame(const SlotReading &slot, afterglow_frame &frame) const {
    const std::size_t known = std::min<std::size_t>(sizeof frame, header_.frame_size);
    frame = {};
    seqlock::load(&frame, slot.bytes + sizeof(std::uint64_t), known);
}

void RingView::copy_plane(const SlotReading &slot, const afterglow_plane &plane, void *to) {
    const std::size_t row = row_bytes(plane);
    for (std::size_t v = 0; v < plane.height; ++v)
        seqlock::load(static_cast<unsigned char *>(to) + v * row,
                      slot.bytes + plane.offset + v * plane.stride_bytes, row);
}

} // namespace afterglow
