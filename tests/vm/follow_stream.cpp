// SPDX-License-Identifier: Apache-2.0
// follow_stream [images]: reads frames from the system bus's daemon, and from the next one when
// that has gone. Each event is a line, with the milliseconds since the machine's start:
//
//     T_MS open
//     T_MS frame INDEX SOURCE
//     T_MS away             the daemon is gone
//     T_MS reconnected      the stream is now that of another daemon
//     T_MS end ERROR        the stream is over; the last line
#include "afterglow/afterglow.h"

#include <cerrno>
#include <cinttypes>
#include <cstdio>
#include <cstring>
#include <ctime>
#include <poll.h>

namespace {

void say(const char *event, const char *more = "") {
    timespec now{};
    ::clock_gettime(CLOCK_MONOTONIC, &now);
    std::printf("%" PRId64 " %s%s\n",
                now.tv_sec * std::int64_t{1000} + now.tv_nsec / std::int64_t{1'000'000}, event,
                more);
}

/// The next thing that happens to the stream: 0 with a frame, or what the library says.
int next(afterglow_stream *stream, afterglow_frame &frame) {
    pollfd something = {afterglow_fd(stream), POLLIN, 0};
    ::poll(&something, 1, 1000);
    if (const int error = afterglow_wait(stream, 0); error != 0)
        return error;
    frame = {};
    frame.size = sizeof frame;
    return afterglow_read_latest(stream, &frame, nullptr, 0);
}

/// Until the stream is over: why.
int follow(afterglow_stream *stream) {
    for (bool away = false;;) {
        afterglow_frame frame;
        const int error = next(stream, frame);
        switch (error) {
        case 0: {
            char more[64];
            std::snprintf(more, sizeof more, " %" PRIu64 " %u", frame.index, frame.source);
            say("frame", more);
            break;
        }
        case -ECONNRESET:
            say("reconnected");
            away = false;
            break;
        case -EINPROGRESS:
            if (!away)
                say("away");
            away = true;
            break;
        case -EAGAIN:
        case -EINTR:
        case -ETIMEDOUT:
            break;
        default:
            return error;
        }
    }
}

} // namespace

int main(int argc, char **argv) {
    std::setvbuf(stdout, nullptr, _IOLBF, 0);
    afterglow_options options = {};
    options.size = sizeof options;
    options.flags = AFTERGLOW_RECONNECT;
    if (argc == 2 && std::strcmp(argv[1], "images") == 0) {
        options.flags |= AFTERGLOW_IMAGES;
    } else if (argc != 1) {
        std::fprintf(stderr, "usage: follow_stream [images]\n");
        return 2;
    }
    afterglow_stream *stream = nullptr;
    int error = afterglow_open(&options, &stream);
    if (error == 0) {
        say("open");
        error = follow(stream);
    }
    say("end ", ::strerrorname_np(-error));
    afterglow_close(stream);
    return 1;
}
