/* SPDX-License-Identifier: Apache-2.0 */
/*
 * The layout of afterglow's shared memories, version 2. All numbers are little-endian.
 *
 *   afterglow_ring_header, afterglow_plane[plane_count]
 *   slot 0: afterglow_slot_header, then the planes
 *   slot 1: ...
 *
 * A stream has one memory for depth and confidence and, for readers that may see images, another
 * for the luma plane. Both have this layout and the same frames, frame n in slot n % slot_count of
 * each; but frames of which nobody could see the image are left out of the latter.
 *
 * One process writes; readers map it read-only. A slot's `sequence` is 2n+1 while frame n is
 * written there, 2n+2 when it is complete, and 0 when nothing is in it. A reader copies the slot
 * out between two loads of `sequence` and keeps the copy only when both gave 2n+2.
 *
 * Later minor versions add fields at the ends of structs. So a reader takes the sizes of structs
 * from the header, not from its compiler, reads no field beyond them, and skips what it does not
 * know.
 */
#ifndef AFTERGLOW_RING_H
#define AFTERGLOW_RING_H

#include <stdint.h>

#ifdef __cplusplus
extern "C" {
#endif

#define AFTERGLOW_RING_MAGIC 0x776f6c6772746661ull /* "aftrglow" */
#define AFTERGLOW_RING_MAJOR 2                     /* another number: unreadable to you */
#define AFTERGLOW_RING_MINOR 1                     /* a higher one: fields were added at the ends */
#define AFTERGLOW_MAX_PLANES 8

/* What a plane's pixels mean. */
enum afterglow_plane_kind {
    AFTERGLOW_PLANE_DEPTH = 1, /* along Z, in `unit` metres; 0 = no depth */
    /* 0: no depth. 255: measured in this frame. 1 to 254: estimated; the expected relative error of
     * the depth against a reading of the TOF camera is (255 - c) * unit, and 1 also stands for
     * larger and unknown errors. While no stream asks for confidences, those of estimated frames
     * are 0 and 1 alone. */
    AFTERGLOW_PLANE_CONFIDENCE = 2,
    /* The colour camera's picture, as it came. It shows what the depth shows, pixel by pixel, where
     * the colour camera is the published one; else it may have another size. */
    AFTERGLOW_PLANE_LUMA = 3,
};

/* How a pixel is stored: the FourCC of the V4L2 pixel format that is the same. */
#define AFTERGLOW_FOURCC(a, b, c, d)                                                               \
    ((uint32_t)(a) | ((uint32_t)(b) << 8) | ((uint32_t)(c) << 16) | ((uint32_t)(d) << 24))
#define AFTERGLOW_FORMAT_Z16 AFTERGLOW_FOURCC('Z', '1', '6', ' ')  /* uint16 */
#define AFTERGLOW_FORMAT_GREY AFTERGLOW_FOURCC('G', 'R', 'E', 'Y') /* uint8 */

/* Where a frame's depth comes from. */
enum afterglow_source {
    AFTERGLOW_NONE = 0,      /* no depth could be given; the depth plane is zeros */
    AFTERGLOW_MEASURED = 1,  /* by the TOF camera, for this image */
    AFTERGLOW_ESTIMATED = 2, /* by warping an earlier measurement */
};

/* How the lens of a camera bends rays; names of ROS in brackets. With r^2 = x^2 + y^2 of the ray
 * (x, y, 1) and theta = atan r, the pixel is (fx x' + cx, fy y' + cy), where
 *   PINHOLE         (x', y') = (x, y)
 *   BROWN_CONRADY   x' = x s + 2 p1 x y + p2 (r^2 + 2 x^2), y' = y s + p1 (r^2 + 2 y^2) + 2 p2 x y,
 *                   s = (1 + k1 r^2 + k2 r^4 + k3 r^6) / (1 + k4 r^2 + k5 r^4 + k6 r^6);
 *                   distortion: k1 k2 p1 p2 k3 k4 k5 k6  (plumb_bob, rational_polynomial)
 *   KANNALA_BRANDT  (x', y') = (x, y) theta (1 + k1 theta^2 + k2 theta^4 + k3 theta^6 +
 *                   k4 theta^8) / r;  distortion: k1 k2 k3 k4  (equidistant) */
enum afterglow_lens {
    AFTERGLOW_LENS_PINHOLE = 0,
    AFTERGLOW_LENS_BROWN_CONRADY = 1,
    AFTERGLOW_LENS_KANNALA_BRANDT = 2,
};

/* The TOF camera's light while this image was taken. */
enum afterglow_emitter {
    AFTERGLOW_EMITTER_UNKNOWN = 0, /* not known; never sent by this daemon */
    AFTERGLOW_EMITTER_OFF = 1,
    AFTERGLOW_EMITTER_ON = 2, /* for a part of the exposure at least */
};

enum afterglow_frame_flags {
    AFTERGLOW_FRAME_TRACKED = 1, /* the poses are those of this image, not of an earlier one */
    AFTERGLOW_FRAME_FIRST = 2,   /* the first since the cameras were started */
    /* Better depth was wanted, and the duty-cycle budget did not allow the light. */
    AFTERGLOW_FRAME_BUDGET_SPENT = 4,
};

enum afterglow_writer_state {
    AFTERGLOW_WRITER_RUNNING = 1,
    AFTERGLOW_WRITER_CLOSED = 2,   /* no frame will follow; open a new stream */
    AFTERGLOW_WRITER_REPLACED = 3, /* frames from `head` on are in the memory sent last */
};

struct afterglow_plane {
    uint32_t kind;   /* enum afterglow_plane_kind */
    uint32_t format; /* AFTERGLOW_FORMAT_... */
    uint32_t width;  /* pixels */
    uint32_t height; /* pixels */
    uint32_t pixel_bytes;
    uint32_t stride_bytes; /* from row to row; a multiple of 8 */
    uint64_t offset;       /* from the start of a slot; a multiple of 8 */
    double unit;           /* what 1 stands for: depth: metres; confidence: relative error; or 0 */
};

#define AFTERGLOW_NO_MEASUREMENT UINT64_MAX

/* What is known of a frame. */
struct afterglow_frame {
    /* In a ring: the bytes of this struct that the daemon knows. Callers of libafterglow set it to
     * sizeof(struct afterglow_frame) before the first call; the library leaves it as it is, writes
     * no more than that, and zeros for fields that it or the daemon does not know. */
    uint32_t size;
    uint32_t flags;       /* enum afterglow_frame_flags */
    uint64_t index;       /* counts published frames, from 0, without gaps */
    uint64_t sequence;    /* the colour camera's count; gaps are images it dropped */
    int64_t t_ns;         /* capture time of the image, CLOCK_MONOTONIC; of a recording that is not
                           * played at its pace: the recorded time */
    int64_t published_ns; /* when it was written here, CLOCK_MONOTONIC */
    uint32_t source;      /* enum afterglow_source */
    uint32_t emitter;     /* enum afterglow_emitter */

    /* The measurement that the depth rests on; AFTERGLOW_NO_MEASUREMENT and zeros where none. */
    uint64_t measurement;     /* counts measurements since the daemon's start, from 0 */
    int64_t measurement_t_ns; /* capture time of its depth map, CLOCK_MONOTONIC */
    uint64_t tof_sequence;    /* the TOF camera's count of that map */
    int64_t age_ns;           /* from the image it was measured for to this one */
    uint32_t age_frames;      /* the same in images; 0 when measured */
    uint32_t inliers;         /* matches that agree with the pose */
    float expected_mre;       /* predicted mean relative error, percent; negative: not predicted */
    float coverage;           /* percent of the pixels with depth */

    /* The camera that depth and confidence are seen by, pixels; (0, 0) is the centre of the top
     * left pixel. See also `lens`. Another `calibration` is another camera: it counts from 1. */
    uint32_t calibration;
    /* Counts worlds, from 1: another one says that the tracking was lost, and that poses in it have
     * nothing to do with earlier ones. 0: there is none yet. */
    uint32_t world;
    double fx, fy, cx, cy;
    /* Poses as 3 rows of 4, [R | T], metres. X right, Y down, Z forward. */
    double world_from_camera[12];       /* where the camera is in the world */
    double camera_from_measurement[12]; /* takes points of the measured frame to this one */

    /* Since 2.1. */
    uint32_t lens;        /* of the camera above, enum afterglow_lens */
    uint32_t reserved;    /* 0 */
    double distortion[8]; /* of the lens; those that it has not are 0 */
};

struct afterglow_slot_header {
    uint64_t sequence; /* atomic */
    struct afterglow_frame frame;
};

struct afterglow_ring_header {
    uint64_t magic;
    uint32_t major;
    uint32_t minor;
    uint32_t header_size; /* bytes before slot 0; a multiple of 64 */
    uint32_t slot_count;
    uint64_t slot_stride;      /* bytes from slot to slot; a multiple of 64 */
    uint32_t slot_header_size; /* bytes of a slot before anything else; a multiple of 8 */
    uint32_t frame_size;       /* the writer's sizeof(struct afterglow_frame) */
    uint32_t planes_offset;    /* from the start of the memory to planes[0]; a multiple of 8 */
    uint32_t plane_count;
    uint32_t plane_size;    /* the writer's sizeof(struct afterglow_plane): from plane to plane */
    uint32_t reserved;      /* 0 */
    uint64_t generation;    /* random for each run of the daemon */
    uint8_t reserved_2[64]; /* zeros */
    /* From here to planes_offset, on a cache line of its own, the writer changes things while you
     * read: at offset 128. */
    uint32_t writer_state; /* atomic, enum afterglow_writer_state */
    uint32_t live_reserved;
    uint64_t head; /* atomic; the newest frame is head - 1, if that is not below `first` */
    uint64_t
        first; /* atomic; frames before it are not in this memory; UINT64_MAX: not in use yet */
    uint8_t live_reserved_2[40]; /* zeros */
};

/*
 * The datagrams on a stream's socket, SOCK_SEQPACKET; only the daemon sends. Skip types you do not
 * know, and bytes after those you know. The end of the file is the end of the daemon or of the
 * stream.
 */
enum afterglow_message_type {
    /* There is a new frame; `value`: its index. Left out while earlier ones wait to be read. */
    AFTERGLOW_MESSAGE_FRAME = 1,
    /* The stream goes on in the memory whose descriptors come with it (SCM_RIGHTS): that with
     * depth, then that with images if the stream has them; `value`: the generation. The first
     * datagram of a stream is one. The memory that was used before says
     * AFTERGLOW_WRITER_REPLACED as soon as the new one is in use. */
    AFTERGLOW_MESSAGE_MEMORY = 2,
    /* The last one; `value`: an errno: EPIPE the daemon ends, EACCES a right was taken away. */
    AFTERGLOW_MESSAGE_END = 3,
};

struct afterglow_message {
    uint32_t type; /* enum afterglow_message_type */
    uint32_t size; /* bytes of this struct that the daemon sent */
    uint64_t value;
};

#ifdef __cplusplus
}
#endif
#endif
