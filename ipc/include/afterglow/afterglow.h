/* SPDX-License-Identifier: Apache-2.0 */
/*
 * libafterglow: depth for every camera frame, from afterglowd.
 *
 *     struct afterglow_stream *stream;
 *     int error = afterglow_open(NULL, &stream);
 *     if (error < 0)
 *         errx(1, "%s", afterglow_strerror(error));
 *     struct afterglow_info info = {.size = sizeof info};
 *     afterglow_get_info(stream, &info);
 *     size_t bytes = afterglow_plane_bytes(stream, AFTERGLOW_PLANE_DEPTH);
 *     uint16_t *depth = malloc(bytes);
 *     struct afterglow_buffer to = {.kind = AFTERGLOW_PLANE_DEPTH, .data = depth, .bytes = bytes};
 *     while ((error = afterglow_wait(stream, -1)) == 0) {
 *         struct afterglow_frame frame = {.size = sizeof frame};
 *         if (afterglow_read_latest(stream, &frame, &to, 1) == 0)
 *             use(&frame, depth, info.width, info.height);
 *     }
 *     afterglow_close(stream);
 *
 * Functions that can fail return 0 or a negative errno; the lists below name those that a caller
 * may want to tell apart, afterglow_strerror() has a sentence for each. On failure, outputs and
 * buffers hold nothing of use. NULL where a pointer is needed is -EINVAL.
 *
 * Structs that begin with `size` grow in later versions: set it to sizeof before the call. The
 * library reads and writes no more than that, so a program goes on working with later libraries;
 * and fields that an older daemon does not know are 0.
 *
 * A stream begins with the next frame that is published, and may be used by one thread at a time,
 * different streams at the same time. The library has no thread and no global state, installs no
 * signal handler, and none of it raises SIGPIPE. Descriptors are close-on-exec. As long as a stream
 * is open the daemon keeps its cameras awake.
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

enum afterglow_open_flags {
    /* The images, too: AFTERGLOW_PLANE_LUMA. The daemon gives them only to users that may see
     * them. */
    AFTERGLOW_IMAGES = 1,
    /* afterglow_open() does not wait for the daemon: the stream is open when afterglow_wait() or a
     * reading function says so by not returning -EINPROGRESS. */
    AFTERGLOW_NONBLOCK = 2,
    /* When the daemon ends or is not there yet, wait for the next one; see -ECONNRESET below. The
     * bus starts the daemon for the first opening, but one that has ended has to come back by
     * itself. */
    AFTERGLOW_RECONNECT = 4,
    /* Confidences. While no stream asks for them the daemon does not work them out for estimated
     * frames: AFTERGLOW_PLANE_CONFIDENCE says that the error of their depth is not known (1). A
     * frame whose estimation began before the stream was opened may be one of these. */
    AFTERGLOW_CONFIDENCE = 8,
};

struct afterglow_options {
    uint32_t size;  /* sizeof(struct afterglow_options) */
    uint32_t flags; /* enum afterglow_open_flags */
    /* NULL or "system", "session", or a D-Bus address such as "unix:path=/run/bus". */
    const char *bus;
    /* How long afterglow_open() waits for the daemon's answer, and for its start where the bus
     * starts it; 0: 25 seconds. */
    uint32_t timeout_ms;
    /* The longest time between two frames, 0 to 1000; 0: a frame of every image. The shortest of
     * all open streams counts. The daemon may then leave out frames, which saves work and light. A
     * frame may also come sooner, for example one that was measured. */
    uint32_t interval_ms;
};

/* The picture that a stream gives. Changes only with the daemon's configuration, and then
 * afterglow_frame.calibration changes, too. */
struct afterglow_info {
    uint32_t size;        /* sizeof(struct afterglow_info) */
    uint32_t calibration; /* counts cameras, from 1; 0: no frame has been read yet */
    uint32_t width;       /* of depth and confidence, pixels */
    uint32_t height;
    double fx, fy, cx, cy; /* camera of the frame read last, pixels; 0 before the first; its lens is
                            * in the frame */
    uint64_t generation;   /* random for each run of the daemon */
    uint32_t slot_count;   /* frames that the ring holds: how far back afterglow_read() can reach */
    uint32_t ring_minor;   /* version 2.ring_minor of the daemon's ring */
};

struct afterglow_plane_info {
    uint32_t size;   /* sizeof(struct afterglow_plane_info) */
    uint32_t kind;   /* enum afterglow_plane_kind */
    uint32_t format; /* AFTERGLOW_FORMAT_... */
    uint32_t pixel_bytes;
    uint32_t width;
    uint32_t height;
    double unit; /* what 1 stands for: depth: metres; confidence: relative error; or 0 */
};

/* A plane to copy out and where to: rows from top to bottom without gaps. */
struct afterglow_buffer {
    uint32_t kind;     /* enum afterglow_plane_kind */
    uint32_t reserved; /* 0 */
    void *data;
    size_t bytes; /* size of `data`: at least afterglow_plane_bytes() */
};

/* A plane where it lies in the ring. */
struct afterglow_view {
    uint32_t kind; /* enum afterglow_plane_kind; set by the caller */
    uint32_t stride_bytes;
    const void *data;
};

/*
 * Asks the daemon for a stream. `options`: NULL for the system bus, depth only, and 25 seconds.
 *   -ECONNREFUSED, -ENOENT  there is no such bus
 *   -EHOSTUNREACH           no afterglowd is on it
 *   -EACCES                 you may not read depth, or not see images
 *   -ENOBUFS                you, or all together, have too many streams open
 *   -EBUSY                  you have asked too often; try again later
 *   -ETIMEDOUT              the daemon does not answer
 *   -EINVAL                 an option is unknown or out of range, here or to an older daemon
 *   -EPROTO, -EPROTONOSUPPORT, -EPERM, -EPIPE  as afterglow_open_fd()
 */
AFTERGLOW_API int afterglow_open(const struct afterglow_options *options,
                                 struct afterglow_stream **stream);

/*
 * The same from the descriptor that the D-Bus method OpenStream gave, for callers with a D-Bus
 * connection of their own. It belongs to the library from the call on: it is closed by
 * afterglow_close(), or before this returns an error. Nothing in the memory is trusted.
 *   -EPROTO           not a stream's socket, or a ring that contradicts itself
 *   -EPROTONOSUPPORT  a ring of another major version
 *   -EPERM            the memory lacks seals: others could write or shrink it
 *   -EPIPE            the daemon has stopped since
 */
AFTERGLOW_API int afterglow_open_fd(int socket, struct afterglow_stream **stream);

/* Ends the stream. NULL is allowed. */
AFTERGLOW_API void afterglow_close(struct afterglow_stream *stream);

/* Size and camera. -EINPROGRESS: the stream is not open yet. */
AFTERGLOW_API int afterglow_get_info(const struct afterglow_stream *stream,
                                     struct afterglow_info *info);

/* -ENOENT: the stream has no such plane. -EINPROGRESS as above. */
AFTERGLOW_API int afterglow_get_plane_info(const struct afterglow_stream *stream, uint32_t kind,
                                           struct afterglow_plane_info *info);

/* Size of the buffer that a plane needs: width * height * pixel_bytes. 0: there is no such
 * plane. */
AFTERGLOW_API size_t afterglow_plane_bytes(const struct afterglow_stream *stream, uint32_t kind);

/*
 * Waits until there is a frame newer than the newest one read; at once when there is. `timeout_ms`:
 * 0 only looks, negative waits for ever.
 *   -ETIMEDOUT    none came
 *   -EPIPE        the daemon is gone, however it died, or has ended this stream: close it
 *   -EACCES       the daemon has taken a right away from you: close the stream
 *   -EINTR        a signal handler ran
 *   -EINPROGRESS  (with timeout 0) the stream is not open yet; or, with AFTERGLOW_RECONNECT, the
 *                 daemon is gone and the next one not there yet
 *   -ECONNRESET   (AFTERGLOW_RECONNECT) the stream is now that of another daemon: ask for
 *                 afterglow_get_info() and sizes anew, indices start over. Said once for each.
 * And the errors of afterglow_open(), where they end a stream that was not open yet.
 */
AFTERGLOW_API int afterglow_wait(struct afterglow_stream *stream, int timeout_ms);

/*
 * For poll loops, one descriptor as long as the stream lives: readable (POLLIN) when a frame may
 * have come, when the daemon is gone, and when there is something to do for opening. Do nothing
 * with it but wait; the reading functions and afterglow_wait() do what is to be done and make it
 * quiet again. It may be readable with nothing new to read: then afterglow_read_latest() says
 * -EAGAIN. The descriptor stays the stream's. -EINVAL for NULL.
 */
AFTERGLOW_API int afterglow_fd(const struct afterglow_stream *stream);

/*
 * Copies the newest frame out: what is known of it, and the `buffer_count` planes asked for (0,
 * with `buffers` NULL, for none). `frame` may be NULL.
 *   -EAGAIN    there is no frame newer than the newest one read
 *   -ENOENT    the stream has no such plane
 *   -EMSGSIZE  a buffer is too small
 *   -EBADMSG   the frame contradicts itself
 *   -EPIPE, -EACCES, -EINPROGRESS, -ECONNRESET  as afterglow_wait()
 */
AFTERGLOW_API int afterglow_read_latest(struct afterglow_stream *stream,
                                        struct afterglow_frame *frame,
                                        const struct afterglow_buffer *buffers,
                                        size_t buffer_count);

/*
 * The same for the frame of that index (afterglow_frame.index), as often as wanted. For readers
 * that want every frame: ask for the last index + 1, and for the latest when that is too late.
 *   -EAGAIN  it is not published yet (-EPIPE: and will never be)
 *   -ESTALE  it has been overwritten, or is older than the stream
 */
AFTERGLOW_API int afterglow_read(struct afterglow_stream *stream, uint64_t index,
                                 struct afterglow_frame *frame,
                                 const struct afterglow_buffer *buffers, size_t buffer_count);

/*
 * The newest frame without a copy: `views` tell where its planes lie. What they point to may be
 * overwritten at any time, after slot_count - 1 further frames; so use it, then ask
 * afterglow_peek_valid(), and throw the result away when that says no. The memory stays readable
 * until the next call that is not afterglow_peek_valid() or afterglow_get_info(). Marks the frame
 * as read. Errors as afterglow_read_latest().
 */
AFTERGLOW_API int afterglow_peek(struct afterglow_stream *stream, struct afterglow_frame *frame,
                                 struct afterglow_view *views, size_t view_count);

/* 1: all that was read of the last afterglow_peek() so far is whole. 0: it is not, or there was
 * none. */
AFTERGLOW_API int afterglow_peek_valid(const struct afterglow_stream *stream);

/* Frames that were passed over: published after the first one read and never read before a newer
 * one was. 0 for NULL. */
AFTERGLOW_API uint64_t afterglow_skipped(const struct afterglow_stream *stream);

/* A sentence for a negative errno that one of these functions gave. Never NULL, never freed. */
AFTERGLOW_API const char *afterglow_strerror(int error);

#ifdef __cplusplus
}
#endif
#endif
