// SPDX-License-Identifier: Apache-2.0
#include "tests/fake_v4l2.hpp"

#include <sys/mman.h>

#include <algorithm>
#include <cerrno>
#include <cstdlib>
#include <cstring>
#include <unistd.h>

namespace afterglow {
namespace {

constexpr std::uint32_t buffer_count = 4;

int fail(int code) {
    errno = code;
    return -1;
}

} // namespace

FakeV4l2::FakeV4l2() : memory_(::memfd_create("fake_v4l2", MFD_CLOEXEC)) {
    if (::ftruncate(memory_.get(), buffer_count * buffer_size) != 0)
        std::abort();
}

std::vector<std::string> FakeV4l2::video_nodes() {
    return node.empty() ? std::vector<std::string>() : std::vector<std::string>{node};
}

int FakeV4l2::open(const std::string &path) {
    if (node.empty() || path != node)
        return fail(ENOENT);
    if (refusing != 0)
        return fail(refusing);
    ++opened;
    return ::dup(memory_.get());
}

int FakeV4l2::ioctl(int, unsigned long request, void *argument) {
    if (node.empty())
        return fail(ENODEV);
    if (const auto failure = failing.find(request); failure != failing.end())
        return fail(failure->second);
    switch (request) {
    case VIDIOC_QUERY_EXT_CTRL:
        return describe_control(*static_cast<v4l2_query_ext_ctrl *>(argument));
    case VIDIOC_S_CTRL: {
        const auto &control = *static_cast<v4l2_control *>(argument);
        values[control.id] = control.value;
        return 0;
    }
    case VIDIOC_S_EXT_CTRLS: {
        const auto &control = *static_cast<v4l2_ext_controls *>(argument)->controls;
        values[control.id] = control.value;
        return 0;
    }
    case VIDIOC_REQBUFS:
    case VIDIOC_QUERYBUF:
    case VIDIOC_QBUF:
    case VIDIOC_DQBUF:
        return move_buffers(request, argument);
    case VIDIOC_STREAMON:
        streaming = true;
        frames.push_front({std::vector<std::uint8_t>(buffer_size, 0xee), now, 0}); // a stale one
        return 0;
    case VIDIOC_STREAMOFF:
        streaming = false;
        queued.clear();
        return 0;
    default:
        return describe_capture(request, argument);
    }
}

int FakeV4l2::poll(int, std::chrono::nanoseconds timeout) {
    if (!frames.empty() && !queued.empty())
        return 1;
    if (poll_events == 0)
        now += timeout.count();
    return poll_events;
}

int FakeV4l2::describe_capture(unsigned long request, void *argument) {
    switch (request) {
    case VIDIOC_QUERYCAP: {
        auto &about = *static_cast<v4l2_capability *>(argument);
        std::memcpy(about.bus_info, bus_info.c_str(), bus_info.size() + 1);
        about.capabilities = caps | (tells_device_caps ? V4L2_CAP_DEVICE_CAPS : 0);
        about.device_caps = tells_device_caps ? caps : 0;
        return 0;
    }
    case VIDIOC_ENUM_FMT: {
        auto &format = *static_cast<v4l2_fmtdesc *>(argument);
        if (format.index >= formats.size())
            return fail(EINVAL);
        format.pixelformat = formats[format.index].fourcc;
        return 0;
    }
    case VIDIOC_ENUM_FRAMESIZES: {
        auto &size = *static_cast<v4l2_frmsizeenum *>(argument);
        std::uint32_t index = 0;
        for (const FakeFormat &format : formats) {
            if (format.fourcc != size.pixel_format || index++ != size.index)
                continue;
            size.type = V4L2_FRMSIZE_TYPE_DISCRETE;
            size.discrete = {format.width, format.height};
            return 0;
        }
        return fail(EINVAL);
    }
    case VIDIOC_ENUM_FRAMEINTERVALS: {
        auto &interval = *static_cast<v4l2_frmivalenum *>(argument);
        std::uint32_t index = 0;
        for (const FakeFormat &format : formats) {
            if (format.fourcc != interval.pixel_format || format.width != interval.width ||
                index++ != interval.index)
                continue;
            interval.type = V4L2_FRMIVAL_TYPE_DISCRETE;
            interval.discrete = {1, format.fps};
            return 0;
        }
        return fail(EINVAL);
    }
    case VIDIOC_S_FMT: {
        v4l2_pix_format &pix = static_cast<v4l2_format *>(argument)->fmt.pix;
        FakeFormat chosen = formats.front();
        for (const FakeFormat &format : formats) {
            if (format.fourcc == pix.pixelformat && format.width == pix.width)
                chosen = format;
        }
        pix.pixelformat = chosen.fourcc;
        pix.width = chosen.width;
        pix.height = chosen.height;
        pix.field = field;
        pix.bytesperline = chosen.width * chosen.bytes_per_pixel;
        pix.sizeimage = pix.bytesperline * chosen.height;
        return 0;
    }
    case VIDIOC_S_PARM:
        static_cast<v4l2_streamparm *>(argument)->parm.capture.timeperframe = {1, formats[0].fps};
        return 0;
    default:
        return fail(ENOTTY);
    }
}

int FakeV4l2::describe_control(v4l2_query_ext_ctrl &control) const {
    const bool next = (control.id & V4L2_CTRL_FLAG_NEXT_CTRL) != 0;
    const std::uint32_t id = control.id & ~V4L2_CTRL_FLAG_NEXT_CTRL;
    for (const v4l2_query_ext_ctrl &known : controls) {
        if (next ? known.id > id : known.id == id) {
            control = known;
            return 0;
        }
    }
    return fail(EINVAL);
}

int FakeV4l2::move_buffers(unsigned long request, void *argument) {
    if (request == VIDIOC_REQBUFS) {
        auto &buffers = *static_cast<v4l2_requestbuffers *>(argument);
        buffers.count = std::min(buffers.count, buffer_count);
        return 0;
    }
    auto &buffer = *static_cast<v4l2_buffer *>(argument);
    switch (request) {
    case VIDIOC_QUERYBUF:
        buffer.length = buffer_size;
        buffer.m.offset = buffer.index * buffer_size;
        return 0;
    case VIDIOC_QBUF:
        queued.push_back(buffer.index);
        return 0;
    default:
        return dequeue(buffer);
    }
}

int FakeV4l2::dequeue(v4l2_buffer &buffer) {
    if (frames.empty() || queued.empty())
        return fail(EAGAIN);
    const FakeFrame frame = frames.front();
    frames.pop_front();
    buffer.index = queued.front();
    queued.erase(queued.begin());
    const auto at = static_cast<off_t>(buffer.index) * buffer_size;
    if (::pwrite(memory_.get(), frame.bytes.data(), frame.bytes.size(), at) < 0)
        return fail(EIO);
    buffer.bytesused = static_cast<std::uint32_t>(frame.bytes.size());
    buffer.flags = frame.flags;
    buffer.sequence = frame.sequence;
    buffer.timestamp.tv_sec = frame.t_ns / 1'000'000'000;
    buffer.timestamp.tv_usec = frame.t_ns % 1'000'000'000 / 1'000;
    return 0;
}

} // namespace afterglow
