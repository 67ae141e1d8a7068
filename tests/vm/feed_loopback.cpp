// SPDX-License-Identifier: Apache-2.0
// feed_loopback DEVICE WIDTH HEIGHT FPS FRAMES: writes the images of test_pattern.hpp, as GREY,
// into a v4l2loopback device.
#include "core/unique_fd.hpp"
#include "tests/vm/test_pattern.hpp"

#include <linux/videodev2.h>
#include <sys/ioctl.h>

#include <chrono>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <fcntl.h>
#include <thread>
#include <unistd.h>
#include <vector>

int main(int argc, char **argv) {
    using namespace afterglow;
    if (argc != 6) {
        std::fprintf(stderr, "usage: feed_loopback DEVICE WIDTH HEIGHT FPS FRAMES\n");
        return 2;
    }
    const int width = std::atoi(argv[2]);
    const int height = std::atoi(argv[3]);
    const std::chrono::duration<double> period(1 / std::atof(argv[4]));
    const auto frames = static_cast<std::uint32_t>(std::atoi(argv[5]));

    const UniqueFd device(::open(argv[1], O_RDWR | O_CLOEXEC));
    v4l2_format format = {};
    format.type = V4L2_BUF_TYPE_VIDEO_OUTPUT;
    format.fmt.pix.width = static_cast<std::uint32_t>(width);
    format.fmt.pix.height = static_cast<std::uint32_t>(height);
    format.fmt.pix.pixelformat = V4L2_PIX_FMT_GREY;
    format.fmt.pix.field = V4L2_FIELD_NONE;
    format.fmt.pix.bytesperline = format.fmt.pix.width;
    format.fmt.pix.sizeimage = format.fmt.pix.width * format.fmt.pix.height;
    if (::ioctl(device.get(), VIDIOC_S_FMT, &format) != 0) {
        std::perror("feed_loopback");
        return 1;
    }
    std::vector<std::uint8_t> image(static_cast<std::size_t>(width * height));
    const auto begin = std::chrono::steady_clock::now();
    for (std::uint32_t index = 0; index < frames; ++index) {
        for (int v = 0; v < height; ++v)
            std::memset(&image[static_cast<std::size_t>(v * width)], vm::pattern(index, v),
                        static_cast<std::size_t>(width));
        std::this_thread::sleep_until(
            begin +
            std::chrono::duration_cast<std::chrono::steady_clock::duration>(index * period));
        if (::write(device.get(), image.data(), image.size()) < 0) {
            std::perror("feed_loopback");
            return 1;
        }
    }
    return 0;
}
