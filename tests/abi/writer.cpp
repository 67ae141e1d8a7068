// SPDX-License-Identifier: Apache-2.0
// abi_writer PROGRAM ARGUMENT: runs a program whose descriptor 3 is a stream with three frames that
// tests/abi/reader.c knows, and ends as it does.
#include "ipc/ring/stream_message.hpp"

#include <sys/socket.h>
#include <sys/wait.h>

#include <cerrno>
#include <cstdio>
#include <fcntl.h>
#include <unistd.h>

using namespace afterglow;

namespace {

constexpr int width = 33;
constexpr int height = 7;

afterglow_frame frame_of(std::uint64_t index) {
    afterglow_frame frame = {};
    frame.size = sizeof frame;
    frame.flags = AFTERGLOW_FRAME_TRACKED;
    frame.index = index;
    frame.sequence = index + 100;
    frame.t_ns = 1000;
    frame.published_ns = 1001;
    frame.source = AFTERGLOW_MEASURED;
    frame.emitter = AFTERGLOW_EMITTER_ON;
    frame.measurement = 7;
    frame.measurement_t_ns = 900;
    frame.tof_sequence = 8;
    frame.age_ns = 33;
    frame.age_frames = 2;
    frame.inliers = 55;
    frame.expected_mre = 1.5F;
    frame.coverage = 87.5F;
    frame.calibration = 3;
    frame.world = 9;
    frame.fx = 500;
    frame.fy = 501;
    frame.cx = 16;
    frame.cy = 3;
    for (int i = 0; i < 12; ++i) {
        frame.world_from_camera[i] = i;
        frame.camera_from_measurement[i] = -i;
    }
#if AFTERGLOW_RING_MINOR >= 1
    frame.lens = AFTERGLOW_LENS_KANNALA_BRANDT;
    frame.distortion[0] = 0.25;
    frame.distortion[7] = -0.5;
#endif
#ifdef GROWN
    frame.grown[0] = 1.25;
    frame.grown[2] = 3.75;
#endif
    return frame;
}

void publish(RingMemory &memory, std::uint64_t index) {
    const auto number = static_cast<int>(index + 1);
    const Image<std::uint16_t> depth(width, height, static_cast<std::uint16_t>(1000 * number));
    const Image<std::uint8_t> bytes(width, height, static_cast<std::uint8_t>(number));
    memory.begin_frame(index);
#ifdef GROWN // the first plane is one that nobody knows
    memory.store_plane(index, 0, bytes.view());
    memory.store_plane(index, 1, depth.view());
    memory.store_plane(index, 2, bytes.view());
#else
    memory.store_plane(index, 0, depth.view());
    memory.store_plane(index, 1, bytes.view());
#endif
    memory.end_frame(frame_of(index));
}

/// Runs the program with these as its descriptors 3 and 4.
pid_t run(char **command, const UniqueFd &stream, const UniqueFd &opened) {
    const pid_t child = ::fork();
    if (child == 0) {
        const int both[] = {::fcntl(stream.get(), F_DUPFD, 10), ::fcntl(opened.get(), F_DUPFD, 10)};
        if (::dup2(both[0], 3) == 3 && ::dup2(both[1], 4) == 4)
            ::execv(command[0], command);
        ::_exit(3);
    }
    return child;
}

} // namespace

int main(int argc, char **argv) {
    const PlaneFormat formats[] = {
#ifdef GROWN
        {77, AFTERGLOW_FORMAT_GREY, 1, 0},
#endif
        {AFTERGLOW_PLANE_DEPTH, AFTERGLOW_FORMAT_Z16, 2, 0.001},
        {AFTERGLOW_PLANE_CONFIDENCE, AFTERGLOW_FORMAT_GREY, 1, 0.0005},
    };
    Result<RingMemory> memory = RingMemory::create(width, height, formats, 4, 42);
    int sockets[2];
    int pipes[2];
    if (argc != 3 || !memory || ::pipe2(pipes, O_CLOEXEC) < 0 ||
        ::socketpair(AF_UNIX, SOCK_SEQPACKET | SOCK_CLOEXEC, 0, sockets) < 0)
        return 2;
    UniqueFd ours(sockets[0]);
    UniqueFd theirs(sockets[1]);
    UniqueFd is_open(pipes[0]);
    UniqueFd opened(pipes[1]);
    Result<UniqueFd> depth = memory->reader_fd();
    if (!depth || !send_memory(ours.get(), {std::move(*depth), {}, 0}, 42))
        return 2;
    const pid_t reader = run(argv + 1, theirs, opened);
    theirs = UniqueFd();
    opened = UniqueFd();
    char byte = 0;
    if (::read(is_open.get(), &byte, 1) == 1) { // or it has ended
        memory->begin_at(0);
        for (std::uint64_t index = 0; index < 3; ++index) {
            publish(*memory, index);
            send_frame(ours.get(), index);
        }
        send_end(ours.get(), EPIPE);
    }
    int status = -1;
    return ::waitpid(reader, &status, 0) == reader && WIFEXITED(status) ? WEXITSTATUS(status) : 4;
}
