/* SPDX-License-Identifier: Apache-2.0 */
/*
 * libafterglow: depth for every camera frame, from afterglowd.
 *
 *     struct afterglow_stream *stream;
 *     int error = afterglow_open(NULL, &stream);
 *     if (error < 0)
 *         errx(1, "%s", afterglow_strerror(error));
 *     struct afterglow_stream_info info;
 *     afterglow_info(stream, &info);
 *     size_t bytes = afterglow_plane_bytes(stream, AFTERGLOW_PLANE_DEPTH);
 *     uint16_t *depth = malloc(bytes);
 *     struct afterglow_buffer want = {AFTERGLOW_PLANE_DEPTH, depth, bytes};
 *     while ((error = afterglow_wait(stream, 1000)) == 0) {
 *         struct afterglow_frame frame;
 *         if (afterglow_read_latest(stream, &frame, &want, 1) == 0)
 *             use(&frame, depth, info.width, info.height);
 *     }
 *     afterglow_close(stream);
 *
 * Functions that can fail return 0 or a negative errno; the lists below name those that a caller
 * may want to tell apart, afterglow_strerror() has a sentence for each. On failure, outputs and
 * buffers hold nothing of use. NULL where a pointer is needed is -EINVAL.
 *
 * A stream may be used by one thread at a time, different streams at the same time. The library
 * has no thread and no global state, installs no signal handler, and none of it raises SIGPIPE.
 * Descriptors are close-on-exec. As long as a stream is open the daemon keeps its cameras awake.
 *
 * A slow reader loses frames (afterglow_skipped() counts them) and disturbs nobody.
 */
#ifndef AFTERGLOW_AFTERGLOW_H
#define AFTERGLOW_AFTERGLOW_H

#include "ring.h"

#include <stddef.h>
#include <stdint.h>

#ifdef __cplusplus
extern "C" {
#endif

#define AFTERGLOW_API __attribute__((visibility("default")))

/* An open stream of frames. */
struct afterglow_stream;

/* What does not change while a stream is open. */
struct afterglow_stream_info {
    uint32_t width;      /* of the depth map, pixels */
    uint32_t height;     /* of the depth map, pixels */
    double fx, fy;       /* pinhole camera of the depth map and its image: focal lengths, pixels */
    double cx, cy;       /* and principal point; (0, 0) is the centre of the top left pixel */
    uint64_t generation; /* random for each run of the daemon */
    uint32_t slot_count; /* frames that the ring holds: how far back afterglow_read() can reach */
    uint32_t plane_count;
    struct afterglow_plane planes[AFTERGLOW_MAX_PLANES]; /* as they lie in the ring */
};

/* A plane to copy out and where to: rows from top to bottom without gaps. */
struct afterglow_buffer {
    uint32_t kind; /* enum afterglow_plane_kind */
    void *data;
    size_t bytes; /* size of `data`: at least afterglow_plane_bytes() */
};

/*
 * Asks the daemon for a stream. `bus`: NULL or "system", "session", or a D-Bus address such as
 * "unix:path=/run/bus". Waits for the daemon's answer, and for its start where the bus starts it,
 * at most 25 seconds.
 *   -ECONNREFUSED, -ENOENT  there is no such bus
 *   -EHOSTUNREACH           no afterglowd is on it
 *   -EACCES                 the bus's policy does not let you
 *   -ENOBUFS                you, or all together, have too many streams open
 *   -EPROTO, -EPROTONOSUPPORT, -EPERM, -EPIPE  as afterglow_open_fds()
 */
AFTERGLOW_API int afterglow_open(const char *bus, struct afterglow_stream **stream);

/*
 * The same from the two descriptors that the D-Bus method OpenStream gave, for callers with a
 * D-Bus connection of their own. Both belong to the library from the call on: they are closed by
 * afterglow_close(), or before this returns an error. Nothing in the memory is trusted.
 *   -EPROTO           not a ring, or one that contradicts itself; or not the right kind of socket
 *   -EPROTONOSUPPORT  a ring of another major version
 *   -EPERM            the memory lacks seals: others could write or shrink it
 *   -EPIPE            the daemon has stopped since
 */
AFTERGLOW_API int afterglow_open_fds(int memfd, int socket, struct afterglow_stream **stream);

/* Ends the stream. NULL is allowed. */
AFTERGLOW_API void afterglow_close(struct afterglow_stream *stream);

/* Size, camera and planes. Fails only with -EINVAL. */
AFTERGLOW_API int afterglow_info(const struct afterglow_stream *stream,
                                 struct afterglow_stream_info *info);

/* Size of the buffer that a plane needs: width * height * size of a pixel. 0: there is no such
 * plane. */
AFTERGLOW_API size_t afterglow_plane_bytes(const struct afterglow_stream *stream, uint32_t kind);

/*
 * Waits until there is a frame newer than the newest one read; at once when there is. `timeout_ms`:
 * 0 only looks, negative waits for ever.
 *   -ETIMEDOUT  none came
 *   -EPIPE      the daemon is gone (noticed within 0.1 s, however it died): close the stream
 *   -EINTR      a signal handler ran
 */
AFTERGLOW_API int afterglow_wait(struct afterglow_stream *stream, int timeout_ms);

/*
 * For poll loops: readable (POLLIN) when a frame may have come, POLLHUP when the daemon is gone.
 * Do nothing with it but wait; the afterglow_read functions and afterglow_wait() make it quiet
 * again. It may be readable with nothing new to read: then afterglow_read_latest() says -EAGAIN.
 * The descriptor stays the stream's. -EINVAL for NULL.
 */
AFTERGLOW_API int afterglow_fd(const struct afterglow_stream *stream);

/*
 * Copies the newest frame out: what is known of it, and the `buffer_count` planes asked for (0,
 * with `buffers` NULL, for none). `frame` may be NULL.
 *   -EAGAIN    there is no frame newer than the newest one read
 *   -EPIPE     the same, and the daemon is gone: there will never be one
 *   -ENOENT    the stream has no such plane
 *   -EMSGSIZE  a buffer is too small
 *   -EBADMSG   the frame contradicts itself
 */
AFTERGLOW_API int afterglow_read_latest(struct afterglow_stream *stream,
                                        struct afterglow_frame *frame,
                                        const struct afterglow_buffer *buffers,
                                        size_t buffer_count);

/*
 * The same for the frame of that index (afterglow_frame.index), as often as wanted. For readers
 * that want every frame: ask for the last index + 1, and for the latest when that is too late.
 *   -EAGAIN  it is not published yet (-EPIPE: and will never be)
 *   -ESTALE  it has been overwritten
 */
AFTERGLOW_API int afterglow_read(struct afterglow_stream *stream, uint64_t index,
                                 struct afterglow_frame *frame,
                                 const struct afterglow_buffer *buffers, size_t buffer_count);

/* Frames that were passed over: published after the first one read and never read before a newer
 * one was. 0 for NULL. */
AFTERGLOW_API uint64_t afterglow_skipped(const struct afterglow_stream *stream);

/* A sentence for a negative errno that one of these functions gave. Never NULL, never freed. */
AFTERGLOW_API const char *afterglow_strerror(int error);

#ifdef __cplusplus
}
#endif
#endif
