// SPDX-License-Identifier: Apache-2.0
//
// The C functions of afterglow/afterglow.h: arguments are checked and structs of all versions are
// translated here, the rest is afterglow_stream's.
#include "afterglow/afterglow.h"
#include "core/base/clock.hpp"
#include "ipc/reader/first_version.hpp"
#include "ipc/reader/stream.hpp"

#include <climits>

#include <algorithm>
#include <cerrno>
#include <chrono>
#include <cstring>
#include <limits>
#include <new>
#include <poll.h>
#include <span>

using namespace afterglow;

namespace {

constexpr std::uint32_t default_timeout_ms = 25'000;
constexpr std::uint32_t all_flags =
    AFTERGLOW_IMAGES | AFTERGLOW_NONBLOCK | AFTERGLOW_RECONNECT | AFTERGLOW_CONFIDENCE;
/// No struct will ever be larger; a larger size is one that was not set.
constexpr std::size_t largest_struct = 4096;

/// Whether a caller's struct can be one of the first version or a later one.
template <class Struct>
bool is_sized(const Struct *given, std::size_t first_version_size) {
    return given != nullptr && given->size >= first_version_size && given->size <= largest_struct;
}

/// Fills a caller's struct of any version; `size` stays.
template <class Struct>
void give(const Struct &value, Struct *to) {
    const std::uint32_t size = to->size;
    std::memset(static_cast<void *>(to), 0, size);
    std::memcpy(static_cast<void *>(to), &value, std::min<std::size_t>(size, sizeof value));
    to->size = size;
}

/// Takes the options of a caller of any version. False when they ask for what this one cannot do.
bool take(const afterglow_options *given, afterglow_options &options) {
    if (given == nullptr)
        return true;
    if (!is_sized(given, first_version::options_size))
        return false;
    const auto *bytes = reinterpret_cast<const unsigned char *>(given);
    const std::size_t known = std::min<std::size_t>(given->size, sizeof options);
    std::memcpy(&options, given, known);
    return std::all_of(bytes + known, bytes + given->size, [](auto byte) { return byte == 0; }) &&
           (options.flags & ~all_flags) == 0 &&
           std::chrono::milliseconds(options.interval_ms) <= StreamOptions::longest_interval;
}

std::int64_t now_ms() {
    return monotonic_ns() / 1'000'000;
}

/// Until something has come from the daemon, the deadline, or a signal; false for the latter.
bool sleep_until(const afterglow_stream &stream, std::int64_t deadline_ms) {
    // The last millisecond counts as a whole one.
    const std::int64_t left = std::max<std::int64_t>(deadline_ms - now_ms(), 0);
    const bool for_ever = deadline_ms == std::numeric_limits<std::int64_t>::max();
    pollfd waited = {stream.link.fd(), POLLIN, 0};
    const int timeout = for_ever ? -1 : static_cast<int>(std::min<std::int64_t>(left, INT_MAX));
    // epoll_wait() would also end when a process that was stopped goes on, without any handler.
    return ::poll(&waited, 1, timeout) >= 0;
}

int wait_until_open(afterglow_stream &stream, std::int64_t deadline_ms) {
    while (true) {
        stream.update();
        if (stream.is_open())
            return 0;
        if (stream.link.ended())
            return stream.link.problem();
        if (now_ms() >= deadline_ms)
            return stream.link.problem() < 0 ? stream.link.problem() : -ETIMEDOUT;
        sleep_until(stream, deadline_ms);
    }
}

std::size_t plane_bytes(const afterglow_stream &stream, std::uint32_t kind) {
    const afterglow_plane *plane = stream.is_open() ? stream.ring().plane(kind) : nullptr;
    return plane == nullptr ? 0 : RingView::row_bytes(*plane) * plane->height;
}

int check_buffers(const afterglow_stream &stream, std::span<const afterglow_buffer> buffers) {
    for (const afterglow_buffer &buffer : buffers) {
        if (buffer.data == nullptr || buffer.reserved != 0)
            return -EINVAL;
        const std::size_t needed = plane_bytes(stream, buffer.kind);
        if (stream.is_open() && needed == 0)
            return -ENOENT;
        if (buffer.bytes < needed)
            return -EMSGSIZE;
    }
    return 0;
}

int check_views(const afterglow_stream &stream, std::span<const afterglow_view> views) {
    for (const afterglow_view &view : views)
        if (stream.is_open() && stream.ring().plane(view.kind) == nullptr)
            return -ENOENT;
    return 0;
}

/// What all reading functions have in common: checks the arguments, sees what has come, checks what
/// is asked for, reads.
template <class Item, class Check, class Read>
int read_frame(afterglow_stream *stream, afterglow_frame *frame, Item *items, std::size_t count,
               Check check, Read read) {
    if (stream == nullptr || (items == nullptr && count > 0) ||
        (frame != nullptr && !is_sized(frame, first_version::frame_size)))
        return -EINVAL;
    const std::span<Item> wanted(items, count);
    if (const int error = stream->update(); error < 0)
        return error;
    if (const int error = check(*stream, wanted); error < 0)
        return error;
    afterglow_frame copy{};
    if (const int error = read(copy, wanted); error < 0)
        return error;
    if (frame != nullptr)
        give(copy, frame);
    return 0;
}

} // namespace

int afterglow_open(const afterglow_options *given, afterglow_stream **stream) {
    afterglow_options options{};
    if (stream == nullptr)
        return -EINVAL;
    *stream = nullptr;
    if (!take(given, options))
        return -EINVAL;
    std::unique_ptr<afterglow_stream> opened(new (std::nothrow) afterglow_stream);
    if (!opened)
        return -ENOMEM;
    opened->bus.reset(::strdup(options.bus != nullptr ? options.bus : "system"));
    if (!opened->bus)
        return -ENOMEM;
    const std::uint32_t timeout_ms =
        options.timeout_ms != 0 ? options.timeout_ms : default_timeout_ms;
    if (const int error =
            opened->link.create({opened->bus.get(),
                                 {.images = (options.flags & AFTERGLOW_IMAGES) != 0,
                                  .confidence = (options.flags & AFTERGLOW_CONFIDENCE) != 0,
                                  .interval = std::chrono::milliseconds(options.interval_ms)},
                                 (options.flags & AFTERGLOW_RECONNECT) != 0,
                                 std::uint64_t{timeout_ms} * 1000});
        error < 0)
        return error;
    const std::int64_t deadline_ms = now_ms() + timeout_ms;
    opened->link.call();
    if ((options.flags & AFTERGLOW_NONBLOCK) == 0)
        if (const int error = wait_until_open(*opened, deadline_ms); error < 0)
            return error;
    *stream = opened.release();
    return 0;
}

int afterglow_open_fd(int socket, afterglow_stream **stream) {
    UniqueFd owned(socket);
    if (stream == nullptr)
        return -EINVAL;
    *stream = nullptr;
    if (const int error = check_stream_socket(owned); error < 0)
        return error;
    std::unique_ptr<afterglow_stream> opened(new (std::nothrow) afterglow_stream);
    if (!opened)
        return -ENOMEM;
    if (const int error = opened->link.create({}); error < 0)
        return error;
    opened->link.adopt(std::move(owned));
    opened->update();
    // The memory is sent before the socket is handed out.
    if (!opened->is_open())
        return opened->link.ended() ? opened->link.problem() : -EPROTO;
    if (opened->nothing_new() == -EPIPE)
        return -EPIPE;
    *stream = opened.release();
    return 0;
}

void afterglow_close(afterglow_stream *stream) {
    delete stream;
}

int afterglow_get_info(const afterglow_stream *stream, afterglow_info *info) {
    if (stream == nullptr || !is_sized(info, first_version::info_size))
        return -EINVAL;
    if (!stream->is_open())
        return -EINPROGRESS;
    const afterglow_ring_header &header = stream->ring().header();
    const afterglow_plane &depth = *stream->ring().plane(AFTERGLOW_PLANE_DEPTH);
    const afterglow_frame &last = stream->last_frame();
    afterglow_info value{};
    value.calibration = last.calibration;
    value.width = depth.width;
    value.height = depth.height;
    value.fx = last.fx;
    value.fy = last.fy;
    value.cx = last.cx;
    value.cy = last.cy;
    value.generation = header.generation;
    value.slot_count = header.slot_count;
    value.ring_minor = header.minor;
    give(value, info);
    return 0;
}

int afterglow_get_plane_info(const afterglow_stream *stream, uint32_t kind,
                             afterglow_plane_info *info) {
    if (stream == nullptr || !is_sized(info, first_version::plane_info_size))
        return -EINVAL;
    if (!stream->is_open())
        return -EINPROGRESS;
    const afterglow_plane *plane = stream->ring().plane(kind);
    if (plane == nullptr)
        return -ENOENT;
    afterglow_plane_info value{};
    value.kind = plane->kind;
    value.format = plane->format;
    value.pixel_bytes = plane->pixel_bytes;
    value.width = plane->width;
    value.height = plane->height;
    value.unit = plane->unit;
    give(value, info);
    return 0;
}

size_t afterglow_plane_bytes(const afterglow_stream *stream, uint32_t kind) {
    return stream == nullptr ? 0 : plane_bytes(*stream, kind);
}

int afterglow_wait(afterglow_stream *stream, int timeout_ms) {
    if (stream == nullptr)
        return -EINVAL;
    const std::int64_t deadline_ms =
        timeout_ms < 0 ? std::numeric_limits<std::int64_t>::max() : now_ms() + timeout_ms;
    while (true) {
        if (const int error = stream->update(); error < 0)
            return error;
        const int nothing = stream->nothing_new(); // before the look for a frame
        if (stream->has_new())
            return 0;
        if (nothing != -EAGAIN && nothing != -EINPROGRESS)
            return nothing;
        if (now_ms() >= deadline_ms)
            return timeout_ms == 0 && nothing == -EINPROGRESS ? -EINPROGRESS : -ETIMEDOUT;
        if (!sleep_until(*stream, deadline_ms))
            return -EINTR;
    }
}

int afterglow_fd(const afterglow_stream *stream) {
    return stream == nullptr ? -EINVAL : stream->link.fd();
}

int afterglow_read_latest(afterglow_stream *stream, afterglow_frame *frame,
                          const afterglow_buffer *buffers, size_t buffer_count) {
    return read_frame(stream, frame, buffers, buffer_count, check_buffers,
                      [&](afterglow_frame &copy, std::span<const afterglow_buffer> wanted) {
                          return stream->read_latest(copy, wanted);
                      });
}

int afterglow_read(afterglow_stream *stream, uint64_t index, afterglow_frame *frame,
                   const afterglow_buffer *buffers, size_t buffer_count) {
    return read_frame(stream, frame, buffers, buffer_count, check_buffers,
                      [&](afterglow_frame &copy, std::span<const afterglow_buffer> wanted) {
                          return stream->read(index, copy, wanted);
                      });
}

int afterglow_peek(afterglow_stream *stream, afterglow_frame *frame, afterglow_view *views,
                   size_t view_count) {
    return read_frame(stream, frame, views, view_count, check_views,
                      [&](afterglow_frame &copy, std::span<afterglow_view> wanted) {
                          return stream->peek_latest(copy, wanted);
                      });
}

int afterglow_peek_valid(const afterglow_stream *stream) {
    return stream != nullptr && stream->peek_is_whole() ? 1 : 0;
}

uint64_t afterglow_skipped(const afterglow_stream *stream) {
    return stream == nullptr ? 0 : stream->skipped();
}
