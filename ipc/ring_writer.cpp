// SPDX-License-Identifier: Apache-2.0
#include "ipc/ring_writer.hpp"

#include "ipc/seqlock.hpp"

#include <climits>
#include <fmt/format.h>
#include <linux/futex.h>
#include <sys/mman.h>
#include <sys/random.h>
#include <sys/syscall.h>

#include <bit>
#include <cassert>
#include <cerrno>
#include <cmath>
#include <cstddef>
#include <cstring>
#include <ctime>
#include <fcntl.h>

namespace afterglow {
namespace {

static_assert(std::endian::native == std::endian::little, "the ring is little-endian");
static_assert(sizeof(afterglow_plane) == 24 && sizeof(afterglow_frame) == 112 &&
              sizeof(afterglow_slot_header) == 120 && sizeof(afterglow_ring_header) == 384 &&
              offsetof(afterglow_ring_header, writer_state) == 320);

constexpr std::uint64_t aligned(std::uint64_t bytes, std::uint64_t to) {
    return (bytes + to - 1) / to * to;
}

Error system_error(const char *what) {
    const int code = errno;
    return {fmt::format("cannot {} the frame ring: {}", what, std::strerror(code)), code};
}

/// Everything of the header that follows from the camera and the number of slots.
afterglow_ring_header describe(const Intrinsics &camera, int slots) {
    afterglow_ring_header header{};
    header.magic = AFTERGLOW_RING_MAGIC;
    header.major = AFTERGLOW_RING_MAJOR;
    header.minor = AFTERGLOW_RING_MINOR;
    header.header_size = sizeof header;
    header.slot_count = static_cast<std::uint32_t>(slots);
    header.slot_header_size = sizeof(afterglow_slot_header);
    header.fx = camera.fx;
    header.fy = camera.fy;
    header.cx = camera.cx;
    header.cy = camera.cy;
    header.writer_state = AFTERGLOW_WRITER_RUNNING;

    std::uint64_t offset = sizeof(afterglow_slot_header);
    const auto add_plane = [&](afterglow_plane_kind kind, std::uint32_t pixel_bytes) {
        afterglow_plane &plane = header.planes[header.plane_count++];
        plane.kind = kind;
        plane.width = static_cast<std::uint32_t>(camera.width);
        plane.height = static_cast<std::uint32_t>(camera.height);
        plane.stride_bytes =
            static_cast<std::uint32_t>(aligned(std::uint64_t{plane.width} * pixel_bytes, 8));
        plane.offset = aligned(offset, 64);
        offset = plane.offset + std::uint64_t{plane.stride_bytes} * plane.height;
    };
    add_plane(AFTERGLOW_PLANE_DEPTH, sizeof(std::uint16_t));
    add_plane(AFTERGLOW_PLANE_CONFIDENCE, sizeof(std::uint8_t));
    add_plane(AFTERGLOW_PLANE_LUMA, sizeof(std::uint8_t));
    header.slot_stride = aligned(offset, 64);
    return header;
}

template <class T>
void store_plane(unsigned char *slot, const afterglow_plane &plane, ImageView<const T> image) {
    assert(image.width() == static_cast<int>(plane.width));
    assert(image.height() == static_cast<int>(plane.height));
    unsigned char *row = slot + plane.offset;
    for (int v = 0; v < image.height(); ++v, row += plane.stride_bytes)
        seqlock::store(row, image.row(v), plane.width * sizeof(T));
}

void store_pose(float (&to)[12], const Pose &pose) {
    for (int row = 0; row < 3; ++row) {
        for (int column = 0; column < 3; ++column)
            to[4 * row + column] = static_cast<float>(pose.R(row, column));
        to[4 * row + 3] = static_cast<float>(pose.T(row));
    }
}

std::int64_t now_ns() {
    timespec now{};
    ::clock_gettime(CLOCK_MONOTONIC, &now);
    return std::int64_t{now.tv_sec} * 1'000'000'000 + now.tv_nsec;
}

/// Lets readers in afterglow_wait() look again.
void wake(afterglow_ring_header &header) {
    __atomic_add_fetch(&header.futex, 1, __ATOMIC_RELEASE);
    ::syscall(SYS_futex, &header.futex, FUTEX_WAKE, INT_MAX, nullptr, nullptr, 0);
}

} // namespace

Result<RingWriter> RingWriter::create(const Intrinsics &camera, int slots) {
    const auto good_length = [](double f) { return std::isfinite(f) && f > 0; };
    if (camera.width < 1 || camera.height < 1 || camera.width > max_side ||
        camera.height > max_side || !good_length(camera.fx) || !good_length(camera.fy) ||
        !std::isfinite(camera.cx) || !std::isfinite(camera.cy))
        return Error{fmt::format("cannot publish frames of a {} x {} camera with focal lengths "
                                 "{}, {} and principal point {}, {}",
                                 camera.width, camera.height, camera.fx, camera.fy, camera.cx,
                                 camera.cy),
                     EINVAL};
    assert(slots >= 2 && slots <= 1024);
    afterglow_ring_header description = describe(camera, slots);
    const std::uint64_t bytes =
        description.header_size + description.slot_count * description.slot_stride;
    if (bytes > std::uint64_t{PTRDIFF_MAX})
        return Error{"cannot map a frame ring of that size on this machine", ENOMEM};
    if (::getrandom(&description.generation, sizeof description.generation, 0) !=
        sizeof description.generation)
        return system_error("draw an identity for");

    UniqueFd fd(::memfd_create("afterglow", MFD_CLOEXEC | MFD_ALLOW_SEALING));
    if (!fd)
        return system_error("create");
    // Reserved and not only sized: running out of memory is an error here, or a SIGBUS later.
    if (::fallocate(fd.get(), 0, 0, static_cast<off_t>(bytes)) < 0)
        return system_error("find memory for");
    void *memory =
        ::mmap(nullptr, bytes, PROT_READ | PROT_WRITE, MAP_SHARED | MAP_POPULATE, fd.get(), 0);
    if (memory == MAP_FAILED)
        return system_error("map");
    auto *header = new (memory) afterglow_ring_header(description);
    RingWriter writer(std::move(fd), header, bytes);
    // The only writable mapping there will ever be exists now.
    if (::fcntl(writer.fd(), F_ADD_SEALS,
                F_SEAL_GROW | F_SEAL_SHRINK | F_SEAL_FUTURE_WRITE | F_SEAL_SEAL) < 0)
        return system_error("seal");
    // The seals suffice; a read-only descriptor says the same to those who look at it. Without
    // /proc there is none.
    UniqueFd read_only(
        ::open(fmt::format("/proc/self/fd/{}", writer.fd()).c_str(), O_RDONLY | O_CLOEXEC));
    if (read_only)
        writer.fd_ = std::move(read_only);
    return writer;
}

RingWriter::RingWriter(RingWriter &&other) noexcept
    : fd_(std::move(other.fd_)), header_(std::exchange(other.header_, nullptr)),
      bytes_(other.bytes_) {}

RingWriter::~RingWriter() {
    if (header_ == nullptr)
        return;
    __atomic_store_n(&header_->writer_state, AFTERGLOW_WRITER_CLOSED, __ATOMIC_RELEASE);
    wake(*header_);
    ::munmap(header_, bytes_);
}

afterglow_frame RingWriter::publish(const Estimate &estimate, LumaView luma,
                                    afterglow_frame frame) {
    frame.index = header_->head;
    frame.age_ns = estimate.age_ns;
    frame.age_frames = estimate.age_frames;
    frame.source = static_cast<std::uint32_t>(estimate.source);
    frame.inliers = static_cast<std::uint32_t>(estimate.inliers);
    frame.expected_mre = estimate.expected_mre;
    frame.coverage = estimate.coverage;
    store_pose(frame.pose, estimate.pose);

    unsigned char *const bytes = reinterpret_cast<unsigned char *>(header_) + header_->header_size +
                                 frame.index % header_->slot_count * header_->slot_stride;
    auto &slot = *reinterpret_cast<afterglow_slot_header *>(bytes);
    seqlock::begin_write(slot.sequence, frame.index);
    store_plane(bytes, header_->planes[0], estimate.depth);
    store_plane(bytes, header_->planes[1], estimate.confidence);
    store_plane(bytes, header_->planes[2], luma);
    frame.published_ns = now_ns();
    seqlock::store(&slot.frame, &frame, sizeof frame);
    seqlock::end_write(slot.sequence, frame.index);

    __atomic_store_n(&header_->head, frame.index + 1, __ATOMIC_RELEASE);
    wake(*header_);
    return frame;
}

} // namespace afterglow
