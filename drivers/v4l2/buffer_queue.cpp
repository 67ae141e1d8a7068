// SPDX-License-Identifier: Apache-2.0
#include "drivers/v4l2/buffer_queue.hpp"

#include "drivers/v4l2/device.hpp"

#include <sys/mman.h>

#include <algorithm>
#include <cerrno>
#include <utility>

namespace afterglow::v4l2 {
namespace {

/// One with us, one being filled, and two so that neither waits for the other.
constexpr std::uint32_t buffer_count = 4;

/// A buffer's description, with room for those of its planes where the device has them.
struct Description {
    explicit Description(std::uint32_t type, std::uint32_t index = 0) {
        buffer.type = type;
        buffer.memory = V4L2_MEMORY_MMAP;
        buffer.index = index;
        if (has_planes()) {
            buffer.m.planes = planes;
            buffer.length = VIDEO_MAX_PLANES;
        }
    }
    Description(const Description &) = delete;
    Description &operator=(const Description &) = delete;

    bool has_planes() const { return buffer.type == V4L2_BUF_TYPE_VIDEO_CAPTURE_MPLANE; }

    v4l2_buffer buffer = {};
    v4l2_plane planes[VIDEO_MAX_PLANES] = {};
};

} // namespace

Result<BufferQueue> BufferQueue::start(SystemCalls &calls, int fd, std::uint32_t buffer_type,
                                       const std::string &device) {
    BufferQueue queue(calls, fd, buffer_type);
    if (const Status reserved = queue.reserve(device); !reserved)
        return reserved.error();
    if (calls.ioctl(fd, VIDIOC_STREAMON, &buffer_type) != 0)
        return device_error(device, "begin to stream", errno);
    return queue;
}

BufferQueue::BufferQueue(BufferQueue &&other) noexcept
    : calls_(other.calls_), fd_(std::exchange(other.fd_, -1)), type_(other.type_),
      memory_(std::exchange(other.memory_, {})) {}

BufferQueue::~BufferQueue() {
    if (fd_ < 0)
        return;
    calls_.ioctl(fd_, VIDIOC_STREAMOFF, &type_);
    for (const Memory &memory : memory_)
        ::munmap(memory.begin, memory.size);
    v4l2_requestbuffers none = {};
    none.type = type_;
    none.memory = V4L2_MEMORY_MMAP;
    calls_.ioctl(fd_, VIDIOC_REQBUFS, &none);
}

Status BufferQueue::reserve(const std::string &device) {
    v4l2_requestbuffers request = {};
    request.count = buffer_count;
    request.type = type_;
    request.memory = V4L2_MEMORY_MMAP;
    if (calls_.ioctl(fd_, VIDIOC_REQBUFS, &request) != 0)
        return device_error(device, "reserve buffers", errno);
    if (request.count < 2)
        return device_error(device, "reserve buffers", ENOMEM);
    memory_.reserve(request.count);
    for (std::uint32_t index = 0; index < request.count; ++index) {
        if (!map(index) || !queue(index))
            return device_error(device, "share its buffers", errno);
    }
    return ok();
}

bool BufferQueue::map(std::uint32_t index) {
    Description about(type_, index);
    if (calls_.ioctl(fd_, VIDIOC_QUERYBUF, &about.buffer) != 0)
        return false;
    const std::size_t size = about.has_planes() ? about.planes[0].length : about.buffer.length;
    const auto offset = about.has_planes() ? about.planes[0].m.mem_offset : about.buffer.m.offset;
    void *begin = ::mmap(nullptr, size, PROT_READ, MAP_SHARED, fd_, offset);
    if (begin == MAP_FAILED)
        return false;
    memory_.push_back({begin, size});
    return true;
}

bool BufferQueue::dequeue(v4l2_buffer &buffer) {
    Description about(type_);
    if (calls_.ioctl(fd_, VIDIOC_DQBUF, &about.buffer) != 0)
        return false;
    if (about.buffer.index >= memory_.size()) {
        errno = EIO; // a driver gone mad
        return false;
    }
    buffer = about.buffer;
    if (about.has_planes()) {
        buffer.bytesused = about.planes[0].bytesused;
        buffer.m.planes = nullptr;
    }
    return true;
}

bool BufferQueue::queue(std::uint32_t index) {
    Description about(type_, index);
    return calls_.ioctl(fd_, VIDIOC_QBUF, &about.buffer) == 0;
}

std::span<const std::uint8_t> BufferQueue::bytes(const v4l2_buffer &buffer) const {
    const Memory &memory = memory_[buffer.index];
    return {static_cast<const std::uint8_t *>(memory.begin),
            std::min<std::size_t>(buffer.bytesused, memory.size)};
}

} // namespace afterglow::v4l2
