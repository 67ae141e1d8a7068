// SPDX-License-Identifier: Apache-2.0
// Stands in for afterglow-libcamera in tests: a camera of 4x2 grey pixels whose id is a script. Its
// letters happen one after the other; then nothing more does.
//
//     at first, instead of streaming: m says nothing   n says that there is no camera   x ends
//                                     b has buffers that are smaller than they are said to be
//     f an image: pixels, number and time are its place in the stream; waits until it was read
//     F the same, without waiting     L the one before the last, only now     g a gap of one
//     d a bad image     s a short one     u "was unplugged"     r rubbish     x ends
//     B an image in a buffer that there is not
//
// Asked to list it does the same with FAKE_LIBCAMERA_LIST: c a camera with one mode, m says
// nothing, n says that libcamera does not start, x ends.
#include "drivers/libcamera/wire.hpp"

#include <linux/videodev2.h>
#include <sys/mman.h>
#include <sys/socket.h>

#include <array>
#include <chrono>
#include <csignal>
#include <cstdlib>
#include <string>
#include <unistd.h>

namespace {

using namespace afterglow;
using namespace afterglow::libcam;
using Kind = Report::Kind;

constexpr std::uint32_t pixels = 8;
constexpr std::uint32_t offset = 4096;
constexpr std::uint32_t buffers = 4;

[[noreturn]] void hang() {
    for (;;)
        ::pause();
}

void say(Kind kind, const char *text = "", int code = 0) {
    Report report;
    report.kind = kind;
    report.code = code;
    report.set_text(text);
    send(helper_socket, report);
}

class Camera {
public:
    explicit Camera(bool buffers_are_small) {
        Report report;
        report.kind = Kind::streaming;
        report.fourcc = V4L2_PIX_FMT_GREY;
        report.width = 4;
        report.height = 2;
        report.stride = 4;
        report.buffer = buffers;
        std::array<int, buffers> memory = {};
        for (std::uint32_t i = 0; i < buffers; ++i) {
            memory[i] = ::memfd_create("image", MFD_CLOEXEC);
            if (::ftruncate(memory[i], offset + (buffers_are_small ? 0 : pixels)) != 0)
                std::abort();
            images_[i] = static_cast<unsigned char *>(
                ::mmap(nullptr, offset + pixels, PROT_WRITE, MAP_SHARED, memory[i], 0));
            report.planes[i] = {offset, pixels};
        }
        send(helper_socket, report, memory);
    }

    void give(std::uint32_t number, std::uint32_t bytes = pixels, Kind kind = Kind::frame) {
        Report report;
        report.kind = kind;
        report.buffer = next_++ % buffers;
        report.bytes = bytes;
        report.sequence = number;
        report.begins_exposure = true;
        report.arrival_ns =
            std::chrono::nanoseconds(std::chrono::steady_clock::now().time_since_epoch()).count();
        report.stamp_ns = report.arrival_ns - number;
        for (std::uint32_t i = 0; i < pixels; ++i)
            images_[report.buffer][offset + i] = static_cast<unsigned char>(number);
        send(helper_socket, report);
    }

    void act(char letter) {
        std::uint32_t released = 0;
        switch (letter) {
        case 'f':
        case 's':
            give(number_++, letter == 'f' ? pixels : pixels - 1);
            if (::recv(helper_socket, &released, sizeof released, 0) != sizeof released ||
                released != (next_ - 1) % buffers)
                std::abort();
            break;
        case 'F':
            give(number_++);
            break;
        case 'L':
            give(number_ - 2);
            break;
        case 'g':
            ++number_;
            break;
        case 'd':
            give(number_++, pixels, Kind::damaged);
            break;
        case 'u':
            say(Kind::failed, "the camera 'X' was unplugged", 19);
            break;
        case 'B': {
            Report report;
            report.kind = Kind::frame;
            report.buffer = buffers;
            report.sequence = number_++;
            send(helper_socket, report);
            break;
        }
        case 'r':
            ::send(helper_socket, "rubbish", 7, 0);
            break;
        case 'x':
            ::_exit(1);
        default:
            break;
        }
    }

private:
    std::array<unsigned char *, buffers> images_{};
    std::uint32_t next_ = 0;
    std::uint32_t number_ = 17; ///< cameras need not begin with 0
};

void list(const std::string &script) {
    for (const char letter : script) {
        if (letter == 'n')
            say(Kind::failed, "libcamera does not start");
        if (letter == 'm')
            hang();
        if (letter == 'x')
            ::_exit(1);
        say(Kind::camera, "\\_SB_.CAM\nA model");
        Report mode;
        mode.kind = Kind::mode;
        mode.fourcc = V4L2_PIX_FMT_YUYV;
        mode.width = 640;
        mode.height = 480;
        send(helper_socket, mode);
    }
    say(Kind::done);
}

} // namespace

int main(int, char **argv) {
    if (std::string(argv[1]) == "list") {
        const char *script = std::getenv("FAKE_LIBCAMERA_LIST");
        list(script != nullptr ? script : "");
        hang();
    }
    const std::string script = argv[2];
    if (script[0] == 'm')
        hang();
    if (script[0] == 'x')
        return 1;
    if (script[0] == 'n') {
        say(Kind::failed, "the camera 'X' is not there (libcamera has none)", 19);
        hang();
    }
    Camera camera(script[0] == 'b');
    for (const char letter : script)
        camera.act(letter);
    hang();
}
