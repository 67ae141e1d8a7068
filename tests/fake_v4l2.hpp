// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "core/base/unique_fd.hpp"
#include "drivers/v4l2/system_calls.hpp"

#include <linux/videodev2.h>

#include <cstdint>
#include <deque>
#include <map>
#include <string>
#include <vector>

namespace afterglow {

/// What a fake camera delivers at a time.
struct FakeFrame {
    std::vector<std::uint8_t> bytes;
    std::int64_t t_ns = 0;
    std::uint32_t sequence = 0;
    std::uint32_t flags = V4L2_BUF_FLAG_TIMESTAMP_MONOTONIC | V4L2_BUF_FLAG_TSTAMP_SRC_SOE;
};

/// A format that the fake camera offers, of one size and rate.
struct FakeFormat {
    std::uint32_t fourcc = V4L2_PIX_FMT_GREY;
    std::uint32_t width = 4;
    std::uint32_t height = 2;
    std::uint32_t fps = 30;
    std::uint32_t bytes_per_pixel = 1;
};

/// A kernel with one camera. The first frame of each stream is one from before, as v4l2loopback
/// gives it. Time passes only while somebody waits for it.
class FakeV4l2 final : public SystemCalls {
public:
    static constexpr std::uint32_t buffer_size = 4096;

    // The camera.
    std::string node = "/dev/video0"; ///< "" = unplugged
    std::string bus_info = "usb-fake-1";
    int refusing = 0; ///< errno of open()
    std::uint32_t caps = V4L2_CAP_VIDEO_CAPTURE | V4L2_CAP_STREAMING;
    bool tells_device_caps = true; ///< as drivers since Linux 3.4 do
    std::vector<FakeFormat> formats = {{}};
    std::uint32_t field = V4L2_FIELD_NONE;
    std::vector<v4l2_query_ext_ctrl> controls; ///< sorted by id
    std::map<std::uint32_t, std::int64_t> values;

    // What comes next.
    std::deque<FakeFrame> frames;         ///< each fills a queued buffer as soon as there is one
    std::map<unsigned long, int> failing; ///< errno by request
    int poll_events = 0;                  ///< given when there is no frame

    // What was done to it.
    std::int64_t now = 1'000'000'000'000;
    int opened = 0;
    bool streaming = false;
    std::vector<std::uint32_t> queued; ///< buffers with the driver, oldest first

    FakeV4l2();

    std::vector<std::string> video_nodes() override;
    int open(const std::string &path) override;
    int ioctl(int fd, unsigned long request, void *argument) override;
    int poll(int fd, std::chrono::nanoseconds timeout) override;
    std::int64_t now_ns() override { return now; }

private:
    int describe_capture(unsigned long request, void *argument);
    int describe_control(v4l2_query_ext_ctrl &control) const;
    int move_buffers(unsigned long request, void *argument);
    int dequeue(v4l2_buffer &buffer);

    UniqueFd memory_; ///< that of the buffers; every open() gives a copy of it
};

} // namespace afterglow
