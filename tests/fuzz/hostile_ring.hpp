// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "afterglow/ring.h"
#include "core/base/unique_fd.hpp"
#include "tests/fuzz/require.hpp"

#include <sys/mman.h>

#include <cstddef>
#include <cstdint>
#include <cstring>
#include <fcntl.h>
#include <span>

/// A small ring that is sound when made, and whose every byte may be changed while others read. Its
/// last byte is the last of a page, and the page behind what a reader maps of it cannot be read, if
/// the kernel puts mappings one below the other.
class HostileRing {
public:
    static constexpr std::size_t bytes = 4096;
    static constexpr std::uint32_t width = 8, height = 4, slots = 3;
    static constexpr std::uint64_t generation = 0x5eed;

    /// With depth and confidence, or with luma.
    explicit HostileRing(bool images) : fd_(memfd_create("ring", MFD_CLOEXEC | MFD_ALLOW_SEALING)) {
        require(ftruncate(fd_.get(), bytes) == 0, "a memfd has a size");
        memory_ = map(bytes, PROT_READ | PROT_WRITE, MAP_SHARED, fd_.get());
        guard_ = map(bytes, PROT_NONE, MAP_PRIVATE | MAP_ANONYMOUS, -1);
        afterglow_ring_header header{};
        header.magic = AFTERGLOW_RING_MAGIC;
        header.major = AFTERGLOW_RING_MAJOR;
        header.minor = AFTERGLOW_RING_MINOR;
        header.header_size = bytes - slots * slot_stride;
        header.slot_count = slots;
        header.slot_stride = slot_stride;
        header.slot_header_size = sizeof(afterglow_slot_header);
        header.frame_size = sizeof(afterglow_frame);
        header.planes_offset = sizeof header;
        header.plane_count = images ? 1 : 2;
        header.plane_size = sizeof(afterglow_plane);
        header.generation = generation;
        header.writer_state = AFTERGLOW_WRITER_RUNNING;
        put(0, header);
        const afterglow_plane depth = {AFTERGLOW_PLANE_DEPTH,
                                       AFTERGLOW_FORMAT_Z16,
                                       width,
                                       height,
                                       2,
                                       2 * width,
                                       sizeof(afterglow_slot_header),
                                       0.001};
        const afterglow_plane confidence = {AFTERGLOW_PLANE_CONFIDENCE,
                                            AFTERGLOW_FORMAT_GREY,
                                            width,
                                            height,
                                            1,
                                            width,
                                            sizeof(afterglow_slot_header) + 2 * width * height,
                                            0.0005};
        const afterglow_plane luma = {AFTERGLOW_PLANE_LUMA,
                                      AFTERGLOW_FORMAT_GREY,
                                      width,
                                      height,
                                      1,
                                      width,
                                      sizeof(afterglow_slot_header),
                                      0};
        put(sizeof header, images ? luma : depth);
        if (!images)
            put(sizeof header + sizeof(afterglow_plane), confidence);
    }
    HostileRing(const HostileRing &) = delete;
    HostileRing &operator=(const HostileRing &) = delete;
    ~HostileRing() {
        munmap(memory_, bytes);
        munmap(guard_, bytes);
    }

    int fd() const { return fd_.get(); }
    void seal(int seals) const { static_cast<void>(fcntl(fd_.get(), F_ADD_SEALS, seals)); }

    /// Writes what fits.
    template <class T>
    void put(std::size_t offset, const T &value) {
        if (offset <= bytes - sizeof value)
            std::memcpy(memory_ + offset, &value, sizeof value);
    }
    /// A sound frame.
    void publish(std::uint64_t index) {
        const std::size_t slot = bytes - (slots - index % slots) * slot_stride;
        afterglow_frame frame{};
        frame.size = sizeof frame;
        frame.index = index;
        frame.source = AFTERGLOW_ESTIMATED;
        frame.fx = frame.fy = width;
        put(slot, afterglow_slot_header{2 * index + 2, frame});
        put(offsetof(afterglow_ring_header, head), index + 1);
    }

private:
    static constexpr std::uint32_t slot_stride = 512;
    static_assert(sizeof(afterglow_slot_header) + 3 * width * height <= slot_stride);

    static unsigned char *map(std::size_t size, int protection, int flags, int fd) {
        void *memory = mmap(nullptr, size, protection, flags, fd, 0);
        require(memory != MAP_FAILED, "memory can be mapped");
        return static_cast<unsigned char *>(memory);
    }

    afterglow::UniqueFd fd_;
    unsigned char *memory_;
    unsigned char *guard_;
};
