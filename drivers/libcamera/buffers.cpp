// SPDX-License-Identifier: Apache-2.0
#include "drivers/libcamera/buffers.hpp"

#include <linux/dma-buf.h>
#include <sys/ioctl.h>
#include <sys/mman.h>

#include <unistd.h>
#include <utility>

namespace afterglow::libcam {

Buffers::Buffers(const Report &streaming, std::vector<UniqueFd> descriptors) {
    if (descriptors.size() != streaming.buffer || descriptors.size() > max_buffers)
        return;
    std::vector<Buffer> mapped;
    for (std::size_t i = 0; i < descriptors.size(); ++i) {
        const Report::BufferPlane extent = streaming.planes[i];
        const std::size_t size = std::size_t{extent.offset} + extent.length;
        // What lies behind the end of the memory could be mapped, but not read.
        const off_t end = ::lseek(descriptors[i].get(), 0, SEEK_END);
        if (extent.length == 0 || end < 0 || static_cast<std::size_t>(end) < size)
            return;
        Mapping mapping(descriptors[i].get(), size);
        if (mapping.begin() == nullptr)
            return;
        mapped.push_back({std::move(descriptors[i]), extent, std::move(mapping)});
    }
    buffers_ = std::move(mapped);
}

Buffers::Mapping::Mapping(int fd, std::size_t size) : size_(size) {
    void *begin = ::mmap(nullptr, size, PROT_READ, MAP_SHARED, fd, 0);
    begin_ = begin == MAP_FAILED ? nullptr : static_cast<std::uint8_t *>(begin);
}

Buffers::Mapping::Mapping(Mapping &&other) noexcept
    : begin_(std::exchange(other.begin_, nullptr)), size_(other.size_) {}

Buffers::Mapping::~Mapping() {
    if (begin_ != nullptr)
        ::munmap(begin_, size_);
}

Buffers::Access::Access(int fd) : fd_(fd) {
    const dma_buf_sync begin = {DMA_BUF_SYNC_START | DMA_BUF_SYNC_READ};
    ::ioctl(fd_, DMA_BUF_IOCTL_SYNC, &begin);
}

Buffers::Access::~Access() {
    const dma_buf_sync end = {DMA_BUF_SYNC_END | DMA_BUF_SYNC_READ};
    ::ioctl(fd_, DMA_BUF_IOCTL_SYNC, &end);
}

} // namespace afterglow::libcam
