// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "core/base/unique_fd.hpp"
#include "drivers/libcamera/wire.hpp"

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

namespace afterglow::libcam {

/// A stream's buffers, mapped into this process. They stay valid when the helper or the camera
/// ends.
class Buffers {
public:
    Buffers() = default;
    /// Maps the buffers of a streaming report; if one cannot be mapped, count() is 0.
    Buffers(const Report &streaming, std::vector<UniqueFd> descriptors);
    Buffers(Buffers &&other) noexcept = default;
    Buffers &operator=(Buffers &&other) noexcept = default;
    ~Buffers() = default;

    std::size_t count() const { return buffers_.size(); }

    /// Calls `read` with the bytes of a frame, once the device's writes are visible.
    /// `frame.buffer` is less than count().
    template <class Read>
    auto read(const Report &frame, const Read &read) const {
        const Buffer &buffer = buffers_[frame.buffer];
        const Access access(buffer.fd.get());
        return read(buffer.plane().first(std::min<std::size_t>(frame.bytes, buffer.extent.length)));
    }

private:
    /// Memory of another process or device; unmapped at the end.
    class Mapping {
    public:
        Mapping(int fd, std::size_t size);
        Mapping(Mapping &&other) noexcept;
        Mapping &operator=(Mapping &&other) = delete;
        ~Mapping();
        const std::uint8_t *begin() const { return begin_; }

    private:
        std::uint8_t *begin_; ///< nullptr: it cannot be mapped
        std::size_t size_;
    };
    struct Buffer {
        UniqueFd fd;
        Report::BufferPlane extent;
        Mapping mapping;
        std::span<const std::uint8_t> plane() const {
            return {mapping.begin() + extent.offset, extent.length};
        }
    };
    /// Brackets the processor's reads of a DMA buffer (DMA_BUF_IOCTL_SYNC).
    class Access {
    public:
        explicit Access(int fd);
        ~Access();
        Access(const Access &) = delete;
        Access &operator=(const Access &) = delete;

    private:
        int fd_;
    };

    std::vector<Buffer> buffers_;
};

} // namespace afterglow::libcam
