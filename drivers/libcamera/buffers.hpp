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

/// A stream's buffers, mapped here. They stay whole when the helper or the camera goes.
class Buffers {
public:
    Buffers() = default;
    /// Of a streaming report with its descriptors; none is mapped if one of them cannot be.
    Buffers(const Report &streaming, std::vector<UniqueFd> descriptors);
    Buffers(Buffers &&other) noexcept = default;
    Buffers &operator=(Buffers &&other) noexcept = default;
    ~Buffers() = default;

    std::size_t count() const { return buffers_.size(); }

    /// Calls `read` with the bytes of a frame, when the device's writing to memory is visible.
    /// `frame.buffer` is less than count().
    template <class Read>
    auto read(const Report &frame, const Read &read) const {
        const Buffer &buffer = buffers_[frame.buffer];
        const Access access(buffer.fd.get());
        return read(buffer.plane().first(std::min<std::size_t>(frame.bytes, buffer.place.length)));
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
        Report::Place place;
        Mapping mapping;
        std::span<const std::uint8_t> plane() const {
            return {mapping.begin() + place.offset, place.length};
        }
    };
    /// While it lives the processor may read a DMA buffer.
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
