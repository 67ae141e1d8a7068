// SPDX-License-Identifier: Apache-2.0
//
// The C functions of afterglow/afterglow.h over a checked ring and the socket of the stream.
#include "afterglow/afterglow.h"
#include "ipc/reader/open_stream.hpp"
#include "ipc/reader/ring_view.hpp"
#include "ipc/unique_fd.hpp"

#include <linux/futex.h>
#include <sys/socket.h>
#include <sys/syscall.h>

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <ctime>
#include <limits>
#include <new>
#include <span>

using afterglow::Copied;
using afterglow::RingView;
using afterglow::UniqueFd;

struct afterglow_stream {
    RingView ring;
    UniqueFd socket;
    std::uint64_t next = 0;    ///< frames below this one have been read or passed over
    std::uint64_t skipped = 0; ///< of those, passed over since the first one read
    bool read_any = false;
    bool hung_up = false; ///< the daemon's end of the socket is closed
};

namespace {

/// How long a daemon that was killed can go unnoticed: only an orderly end wakes the futex.
constexpr std::int64_t liveness_ns = 100'000'000;
/// A copy is overtaken only when the writer goes once around the ring meanwhile.
constexpr int most_attempts = 16;

std::int64_t now_ns() {
    timespec now{};
    ::clock_gettime(CLOCK_MONOTONIC, &now);
    return std::int64_t{now.tv_sec} * 1'000'000'000 + now.tv_nsec;
}

/// Takes the wake-ups off the socket, and notices when its other end is closed.
void drain(afterglow_stream &stream) {
    std::uint64_t index = 0;
    // Bounded: whoever is at the other end could send for ever.
    for (int datagrams = 0; datagrams < 1024 && !stream.hung_up; ++datagrams) {
        const ssize_t got = ::recv(stream.socket.get(), &index, sizeof index, MSG_DONTWAIT);
        if (got < 0 && (errno == EAGAIN || errno == EINTR))
            return;
        stream.hung_up = got <= 0;
    }
}

bool gone(const afterglow_stream &stream) {
    return stream.hung_up || stream.ring.closed();
}

/// Sleeps until the futex is no longer `seen`, at most `timeout_ns`. Returns false when a signal
/// came.
bool sleep_on(const std::uint32_t *futex, std::uint32_t seen, std::int64_t timeout_ns) {
    timespec timeout{};
    timeout.tv_sec = static_cast<time_t>(timeout_ns / 1'000'000'000);
    timeout.tv_nsec = static_cast<long>(timeout_ns % 1'000'000'000);
#ifdef SYS_futex_time64 // 32-bit machines have two calls, one for each size of time_t
    constexpr long call = sizeof(time_t) == 8 ? SYS_futex_time64 : SYS_futex;
#else
    constexpr long call = SYS_futex;
#endif
    return ::syscall(call, futex, FUTEX_WAIT, seen, &timeout, nullptr, 0) == 0 || errno != EINTR;
}

std::size_t plane_bytes(const afterglow_stream &stream, std::uint32_t kind) {
    const afterglow_plane *plane = stream.ring.plane(kind);
    return plane == nullptr ? 0
                            : static_cast<std::size_t>(RingView::row_bytes(*plane) * plane->height);
}

int check_buffers(const afterglow_stream &stream, const afterglow_buffer *buffers,
                  std::size_t count) {
    if (buffers == nullptr && count > 0)
        return -EINVAL;
    for (const afterglow_buffer &buffer : std::span(buffers, count)) {
        if (buffer.data == nullptr)
            return -EINVAL;
        const std::size_t needed = plane_bytes(stream, buffer.kind);
        if (needed == 0)
            return -ENOENT;
        if (buffer.bytes < needed)
            return -EMSGSIZE;
    }
    return 0;
}

void mark_read(afterglow_stream &stream, std::uint64_t index) {
    if (index < stream.next)
        return;
    if (stream.read_any)
        stream.skipped += index - stream.next;
    stream.read_any = true;
    stream.next = index + 1;
}

} // namespace

int afterglow_open(const char *bus, afterglow_stream **stream) {
    if (stream == nullptr)
        return -EINVAL;
    *stream = nullptr;
    UniqueFd memfd;
    UniqueFd socket;
    if (const int error = afterglow::open_stream(bus, memfd, socket); error < 0)
        return error;
    return afterglow_open_fds(memfd.release(), socket.release(), stream);
}

int afterglow_open_fds(int memfd, int socket, afterglow_stream **stream) {
    const UniqueFd memory(memfd);
    UniqueFd wake_ups(socket);
    if (stream == nullptr)
        return -EINVAL;
    *stream = nullptr;
    int type = 0;
    socklen_t type_size = sizeof type;
    if (::getsockopt(socket, SOL_SOCKET, SO_TYPE, &type, &type_size) < 0)
        return errno == ENOTSOCK ? -EPROTO : -errno;
    if (type != SOCK_SEQPACKET)
        return -EPROTO;
    RingView ring;
    if (const int error = RingView::open(memfd, ring); error < 0)
        return error;
    if (ring.closed())
        return -EPIPE;
    auto *opened = new (std::nothrow) afterglow_stream;
    if (opened == nullptr)
        return -ENOMEM;
    opened->ring = std::move(ring);
    opened->socket = std::move(wake_ups);
    *stream = opened;
    return 0;
}

void afterglow_close(afterglow_stream *stream) {
    delete stream;
}

int afterglow_info(const afterglow_stream *stream, afterglow_stream_info *info) {
    if (stream == nullptr || info == nullptr)
        return -EINVAL;
    const afterglow_ring_header &header = stream->ring.header();
    const afterglow_plane &depth = *stream->ring.plane(AFTERGLOW_PLANE_DEPTH);
    *info = {};
    info->width = depth.width;
    info->height = depth.height;
    info->fx = header.fx;
    info->fy = header.fy;
    info->cx = header.cx;
    info->cy = header.cy;
    info->generation = header.generation;
    info->slot_count = header.slot_count;
    info->plane_count = header.plane_count;
    std::copy_n(header.planes, header.plane_count, info->planes);
    return 0;
}

size_t afterglow_plane_bytes(const afterglow_stream *stream, uint32_t kind) {
    return stream == nullptr ? 0 : plane_bytes(*stream, kind);
}

int afterglow_wait(afterglow_stream *stream, int timeout_ms) {
    if (stream == nullptr)
        return -EINVAL;
    const std::int64_t deadline = timeout_ms < 0 ? std::numeric_limits<std::int64_t>::max()
                                                 : now_ns() + std::int64_t{timeout_ms} * 1'000'000;
    while (true) {
        drain(*stream);
        // Before the look at head: what is published after it changes the futex.
        const std::uint32_t seen = __atomic_load_n(stream->ring.futex(), __ATOMIC_ACQUIRE);
        if (stream->ring.head() > stream->next)
            return 0;
        if (gone(*stream))
            return -EPIPE;
        const std::int64_t left = deadline - now_ns();
        if (left <= 0)
            return -ETIMEDOUT;
        if (!sleep_on(stream->ring.futex(), seen, std::min(left, liveness_ns)))
            return -EINTR;
    }
}

int afterglow_fd(const afterglow_stream *stream) {
    return stream == nullptr ? -EINVAL : stream->socket.get();
}

int afterglow_read_latest(afterglow_stream *stream, afterglow_frame *frame,
                          const afterglow_buffer *buffers, size_t buffer_count) {
    if (stream == nullptr)
        return -EINVAL;
    if (const int error = check_buffers(*stream, buffers, buffer_count); error < 0)
        return error;
    drain(*stream);
    const bool last = gone(*stream); // before the look at head: what is there now is all
    afterglow_frame copy{};
    for (int attempt = 0; attempt < most_attempts; ++attempt) {
        const std::uint64_t head = stream->ring.head();
        if (head <= stream->next)
            return last ? -EPIPE : -EAGAIN;
        const Copied copied = stream->ring.copy(head - 1, copy, buffers, buffer_count);
        if (copied == Copied::damaged)
            return -EBADMSG;
        if (copied == Copied::whole) {
            mark_read(*stream, head - 1);
            if (frame != nullptr)
                *frame = copy;
            return 0;
        }
    }
    return last ? -EPIPE : -EAGAIN;
}

int afterglow_read(afterglow_stream *stream, uint64_t index, afterglow_frame *frame,
                   const afterglow_buffer *buffers, size_t buffer_count) {
    if (stream == nullptr)
        return -EINVAL;
    if (const int error = check_buffers(*stream, buffers, buffer_count); error < 0)
        return error;
    drain(*stream);
    const bool last = gone(*stream);
    if (index >= stream->ring.head())
        return last ? -EPIPE : -EAGAIN;
    afterglow_frame copy{};
    switch (stream->ring.copy(index, copy, buffers, buffer_count)) {
    case Copied::whole:
        mark_read(*stream, index);
        if (frame != nullptr)
            *frame = copy;
        return 0;
    case Copied::overwritten:
        return -ESTALE;
    default:
        return -EBADMSG;
    }
}

uint64_t afterglow_skipped(const afterglow_stream *stream) {
    return stream == nullptr ? 0 : stream->skipped;
}

const char *afterglow_strerror(int error) {
    switch (error) {
    case 0:
        return "no error";
    case -EAGAIN:
        return "there is no new frame yet";
    case -EACCES:
        return "the bus does not allow this user to ask for a stream";
    case -EBADMSG:
        return "a frame in the ring contradicts itself";
    case -ECONNREFUSED:
        return "nobody answers at the address of the bus";
    case -EHOSTUNREACH:
        return "no afterglow daemon is on the bus";
    case -EINTR:
        return "a signal came while waiting for a frame";
    case -EINVAL:
        return "the library was called with an invalid argument";
    case -EMSGSIZE:
        return "a buffer is too small for its plane";
    case -ENOMEDIUM:
        return "this user has no session bus";
    case -ENOBUFS:
        return "the daemon has too many streams open to open another one";
    case -ENOENT:
        return "there is no such bus, or no such plane in the stream";
    case -EPERM:
        return "the shared memory lacks the seals that make it safe to read";
    case -EPIPE:
        return "the daemon has closed the stream";
    case -EPROTO:
        return "the shared memory is not an afterglow ring";
    case -EPROTONOSUPPORT:
        return "the daemon's ring is of another version than this library reads";
    case -ESTALE:
        return "the frame has been overwritten by newer ones";
    case -ETIMEDOUT:
        return "no new frame came in the time allowed";
    default: {
        const char *sentence = ::strerrordesc_np(-error);
        return sentence != nullptr ? sentence : "unknown error";
    }
    }
}
