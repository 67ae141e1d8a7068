// SPDX-License-Identifier: Apache-2.0
// Prints how near the nearest thing in view is, for each frame. An argument names another bus than
// the system's.
#include <afterglow/afterglow.hpp>
#include <cstdio>

namespace {

/// Metres; 0: nothing has depth.
double nearest(const afterglow::Frame &frame, double unit) {
    unsigned least = 0;
    for (std::size_t v = 0; v < frame.depth.height(); ++v)
        for (std::size_t u = 0; u < frame.depth.width(); ++u)
            if (const unsigned z = frame.depth(u, v); z != 0 && (least == 0 || z < least))
                least = z;
    return least * unit;
}

} // namespace

int main(int argc, char **argv) {
    try {
        afterglow::Options options;
        if (argc > 1)
            options.bus = argv[1];
        afterglow::Stream stream(options);
        while (true)
            if (stream.wait(std::chrono::seconds(1)))
                if (const auto frame = stream.read_latest())
                    std::printf("frame %llu: %.3f m\n",
                                static_cast<unsigned long long>(frame->info.index),
                                nearest(*frame, stream.depth_unit()));
    } catch (const std::system_error &error) {
        std::fprintf(stderr, "%s\n", error.what());
        return 1;
    }
}
