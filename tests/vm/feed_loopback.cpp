// SPDX-License-Identifier: Apache-2.0
// feed_loopback DEVICE WIDTH HEIGHT FPS FRAMES [FOURCC]: writes the images of test_pattern.hpp into
// a v4l2loopback device, as GREY, or as if they were of another format.
#include "core/base/unique_fd.hpp"
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
    if ((argc != 6 && argc != 7) || (argc == 7 && std::strlen(argv[6]) != 4)) {
        std::fprintf(stderr, "usage: feed_loopback DEVICE WIDTH HEIGHT FPS FRAMES [FOURCC]\n");
        return 2;
    }
    const char *fourcc = argc == 7 ? argv[6] : "GREY";
    const int width = std::atoi(argv[2]);
    const int height = std::atoi(argv[3]);
    const std::chrono::duration<double> period(1 / std::atof(argv[4]));
    const auto frames = static_cast<std::uint32_t>(std::atoi(argv[5]));

    const UniqueFd device(::open(argv[1], O_RDWR | O_CLOEXEC));
    v4l2_format format = {};
    format.type = V4L2_BUF_TYPE_VIDEO_OUTPUT;
    format.fmt.pix.width = static_cast<std::uint32_t>(width);
    format.fmt.pix.height = static_cast<std::uint32_t>(height);
    format.fmt.pix.pixelformat = v4l2_fourcc(fourcc[0], fourcc[1], fourcc[2], fourcc[3]);
    format.fmt.pix.field = V4L2_FIELD_NONE;
    format.fmt.pix.bytesperline = format.fmt.pix.width;
    format.fmt.pix.sizeimage = format.fmt.pix.width * format.fmt.pix.height;
    if (::ioctl(device.get(), VIDIOC_S_FMT, &format) != 0) {
        std::perror("feed_loopback");
        return 1;
    }
    if (format.fmt.pix.width != static_cast<std::uint32_t>(width) ||
        format.fmt.pix.height != static_cast<std::uint32_t>(height)) {
        std::fprintf(stderr, "feed_loopback: the device takes another size\n");
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
