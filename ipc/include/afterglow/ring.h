/* SPDX-License-Identifier: Apache-2.0 */
/*
 * The layout of afterglow's shared memory, version 1. All numbers little-endian.
 *
 *   afterglow_ring_header
 *   slot 0: afterglow_slot_header, then the planes
 *   slot 1: ...
 *
 * One process writes; readers map it read-only. Frame n lives in slot n % slot_count. A slot's
 * `sequence` is 2n+1 while frame n is being written there and 2n+2 when it is complete (0: never
 * used). A reader copies the slot out between two loads of `sequence` and keeps the copy only when
 * both gave 2n+2.
 */
#ifndef AFTERGLOW_RING_H
#define AFTERGLOW_RING_H

#include <stdint.h>

#ifdef __cplusplus
extern "C" {
#endif

#define AFTERGLOW_RING_MAGIC 0x776f6c6772746661ull /* "aftrglow" */
#define AFTERGLOW_RING_MAJOR 1                     /* another number: unreadable to you */
#define AFTERGLOW_RING_MINOR 0                     /* a higher one: fields were added at the ends */
#define AFTERGLOW_MAX_PLANES 8

enum afterglow_plane_kind {
    AFTERGLOW_PLANE_DEPTH = 1, /* uint16, millimetres along Z, 0 = no depth */
    /* uint8. 0: no depth. 255: measured in this frame. 1 to 254: estimated; the expected relative
     * error of the depth is (255 - c) * 0.0005, and 1 also stands for larger and unknown errors. */
    AFTERGLOW_PLANE_CONFIDENCE = 2,
    AFTERGLOW_PLANE_LUMA = 3, /* uint8, the image that the depth belongs to */
};

enum afterglow_source {
    AFTERGLOW_NONE = 0,      /* no depth could be given; the depth plane is zeros */
    AFTERGLOW_MEASURED = 1,  /* by the TOF camera, for this image */
    AFTERGLOW_ESTIMATED = 2, /* by warping an earlier measurement */
};

enum afterglow_writer_state {
    AFTERGLOW_WRITER_RUNNING = 1,
    AFTERGLOW_WRITER_CLOSED = 2, /* no frame will follow; open a new stream */
};

struct afterglow_plane {
    uint32_t kind;         /* enum afterglow_plane_kind */
    uint32_t width;        /* pixels */
    uint32_t height;       /* pixels */
    uint32_t stride_bytes; /* from row to row; a multiple of 8 */
    uint64_t offset;       /* from the start of a slot; a multiple of 8 */
};

/* What is known of a frame. */
struct afterglow_frame {
    uint64_t index;       /* counts published frames, from 0, without gaps */
    uint64_t sequence;    /* the colour camera's count; gaps are images it dropped */
    int64_t t_ns;         /* capture time of the image, CLOCK_MONOTONIC */
    int64_t published_ns; /* when it was written here, CLOCK_MONOTONIC */
    int64_t age_ns;       /* since the measurement this map rests on */
    uint32_t age_frames;  /* the same in images; 0 when measured */
    uint32_t source;      /* enum afterglow_source */
    uint32_t illuminated; /* 1: the TOF light was on for this image */
    uint32_t inliers;     /* matches that agree with the pose */
    float expected_mre;   /* predicted mean relative error, percent; negative: not predicted */
    float coverage;       /* percent of the pixels with depth */
    float pose[12];       /* last measured frame to this one: [R | T], 3 rows of 4, metres */
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
    uint64_t slot_stride; /* bytes from slot to slot; a multiple of 64 */
    uint32_t plane_count;
    uint32_t slot_header_size; /* the writer's sizeof(struct afterglow_slot_header) */
    struct afterglow_plane planes[AFTERGLOW_MAX_PLANES];
    double fx, fy, cx, cy; /* the colour camera that depth is registered to, pixels */
    uint64_t generation;   /* random for each ring: another value is another daemon */
    uint8_t reserved[48];  /* zeros */
    /* Below here, on a cache line of its own, the writer changes things while you read. */
    uint32_t writer_state; /* atomic, enum afterglow_writer_state */
    uint32_t futex; /* atomic; counts publications, FUTEX_WAIT on it (not FUTEX_PRIVATE_FLAG) */
    uint64_t head;  /* atomic; number of frames published: the newest is head - 1 */
    uint8_t live_reserved[48]; /* zeros */
};

#ifdef __cplusplus
}
#endif
#endif
