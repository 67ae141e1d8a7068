// SPDX-License-Identifier: Apache-2.0
// afterglow-libcamera: libcamera in a process of its own, for afterglowd and afterglowctl, with
// whom it is connected by descriptor 3 (drivers/libcamera/wire.hpp).
//
//     afterglow-libcamera list
//     afterglow-libcamera capture ID WIDTH HEIGHT PERIOD_US FORMAT[,FORMAT...]
#include "drivers/libcamera/helper/helper.hpp"
#include "drivers/libcamera/wire.hpp"

#include <sys/socket.h>

#include <cstdio>
#include <cstdlib>
#include <sstream>
#include <string>
#include <unistd.h>

namespace {

using namespace afterglow::libcam;

bool is_connected() {
    int type = 0;
    socklen_t size = sizeof type;
    return ::getsockopt(helper_socket, SOL_SOCKET, SO_TYPE, &type, &size) == 0 &&
           type == SOCK_SEQPACKET;
}

CaptureRequest request_of(char **arguments) {
    CaptureRequest wanted;
    wanted.id = arguments[0];
    wanted.width = std::atoi(arguments[1]);
    wanted.height = std::atoi(arguments[2]);
    wanted.period_us = std::atoll(arguments[3]);
    std::istringstream formats(arguments[4]);
    for (std::string format; std::getline(formats, format, ',');)
        wanted.formats.push_back(static_cast<std::uint32_t>(std::stoul(format)));
    return wanted;
}

} // namespace

int main(int argc, char **argv) {
    const std::string verb = argc > 1 ? argv[1] : "";
    const bool is_understood = (verb == "list" && argc == 2) || (verb == "capture" && argc == 7);
    if (!is_understood || !is_connected()) {
        std::fputs("afterglow-libcamera is started by afterglowd and afterglowctl\n", stderr);
        return 2;
    }
    if (verb == "list")
        list_cameras();
    else
        capture(request_of(argv + 2));
    // Without the library's own farewell, which can hang: the kernel takes all back.
    ::_exit(0);
}
