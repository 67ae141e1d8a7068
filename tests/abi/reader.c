/* SPDX-License-Identifier: Apache-2.0 */
/*
 * reader MINOR: reads three frames of abi_writer from the stream that is descriptor 3, and says on
 * descriptor 4 when it is open. Every struct is followed by bytes that the library must leave
 * alone. Fields up to version 2.MINOR have values; later ones are zeros.
 */
#include "afterglow/afterglow.h"

#include <errno.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#define CHECK(condition)                                                                           \
    do {                                                                                           \
        if (!(condition)) {                                                                        \
            fprintf(stderr, "line %d: %s\n", __LINE__, #condition);                                \
            return 1;                                                                              \
        }                                                                                          \
    } while (0)

enum { width = 33, height = 7, canary = 0xa5, canaries = 512 };

#define GUARDED(type)                                                                              \
    struct {                                                                                       \
        struct type value;                                                                         \
        unsigned char guard[canaries];                                                             \
    }
/* What was in the struct before is to be overwritten, as far as it goes. */
#define PREPARE(guarded)                                                                           \
    (memset(&(guarded), canary, sizeof(guarded)), (guarded).value.size = sizeof(guarded).value)

static int is_untouched(const unsigned char *guard) {
    for (int i = 0; i < canaries; ++i)
        if (guard[i] != canary)
            return 0;
    return 1;
}

static int check_stream(const struct afterglow_stream *stream) {
    GUARDED(afterglow_info) info;
    PREPARE(info);
    CHECK(afterglow_get_info(stream, &info.value) == 0);
    CHECK(is_untouched(info.guard));
    CHECK(info.value.size == sizeof info.value);
    CHECK(info.value.width == width && info.value.height == height);
    CHECK(info.value.generation == 42);
    CHECK(info.value.slot_count == 4);

    GUARDED(afterglow_plane_info) plane;
    PREPARE(plane);
    CHECK(afterglow_get_plane_info(stream, AFTERGLOW_PLANE_DEPTH, &plane.value) == 0);
    CHECK(is_untouched(plane.guard));
    CHECK(plane.value.format == AFTERGLOW_FORMAT_Z16 && plane.value.unit == 0.001);
    CHECK(afterglow_plane_bytes(stream, AFTERGLOW_PLANE_DEPTH) == width * height * 2);
    return 0;
}

static int check_frame(const struct afterglow_frame *frame, uint64_t index, int minor) {
    CHECK(frame->size == sizeof *frame);
    CHECK(frame->index == index);
    CHECK(frame->sequence == index + 100);
    CHECK(frame->t_ns == 1000 && frame->published_ns == 1001);
    CHECK(frame->flags == AFTERGLOW_FRAME_TRACKED);
    CHECK(frame->source == AFTERGLOW_MEASURED && frame->emitter == AFTERGLOW_EMITTER_ON);
    CHECK(frame->measurement == 7 && frame->measurement_t_ns == 900 && frame->tof_sequence == 8);
    CHECK(frame->age_ns == 33 && frame->age_frames == 2 && frame->inliers == 55);
    CHECK(frame->expected_mre == 1.5F && frame->coverage == 87.5F);
    CHECK(frame->calibration == 3 && frame->world == 9);
    CHECK(frame->fx == 500 && frame->fy == 501 && frame->cx == 16 && frame->cy == 3);
    for (int i = 0; i < 12; ++i)
        CHECK(frame->world_from_camera[i] == i && frame->camera_from_measurement[i] == -i);
#if AFTERGLOW_RING_MINOR >= 1
    CHECK(frame->lens == (minor >= 1 ? AFTERGLOW_LENS_KANNALA_BRANDT : 0));
    CHECK(frame->distortion[0] == (minor >= 1 ? 0.25 : 0));
    CHECK(frame->distortion[7] == (minor >= 1 ? -0.5 : 0));
#endif
#ifdef GROWN
    CHECK(frame->grown[0] == (minor >= AFTERGLOW_RING_MINOR ? 1.25 : 0));
    CHECK(frame->grown[2] == (minor >= AFTERGLOW_RING_MINOR ? 3.75 : 0));
#endif
    (void)minor; /* programs of 2.0 have none of them */
    return 0;
}

static int check_frames(struct afterglow_stream *stream, int minor) {
    uint16_t depth[width * height];
    uint8_t confidence[width * height];
    const struct afterglow_buffer want[] = {
        {AFTERGLOW_PLANE_DEPTH, 0, depth, sizeof depth},
        {AFTERGLOW_PLANE_CONFIDENCE, 0, confidence, sizeof confidence}};
    GUARDED(afterglow_frame) frame;
    for (uint64_t index = 0; index < 3; ++index) {
        CHECK(afterglow_wait(stream, 60000) == 0);
        PREPARE(frame);
        CHECK(afterglow_read(stream, index, &frame.value, want, 2) == 0);
        CHECK(is_untouched(frame.guard));
        if (check_frame(&frame.value, index, minor) != 0)
            return 1;
        for (int i = 0; i < width * height; ++i)
            CHECK(depth[i] == 1000 * (index + 1) && confidence[i] == index + 1);
    }
    CHECK(afterglow_wait(stream, 60000) == -EPIPE);
    struct afterglow_view view = {AFTERGLOW_PLANE_DEPTH, 0, NULL};
    PREPARE(frame);
    CHECK(afterglow_peek(stream, &frame.value, &view, 1) == -EPIPE);
    return 0;
}

int main(int argc, char **argv) {
    if (argc != 2)
        return 2;
    const int minor = atoi(argv[1]);
    GUARDED(afterglow_options) options;
    memset(&options, 0, sizeof options);
    options.value.size = sizeof options.value;
    options.value.bus = "unix:path=/nowhere/bus";
    struct afterglow_stream *stream = NULL;
    CHECK(afterglow_open(&options.value, &stream) == -ENOENT);
    CHECK(afterglow_open_fd(3, &stream) == 0);
    CHECK(write(4, "o", 1) == 1);
    const int failed = check_stream(stream) != 0 || check_frames(stream, minor) != 0;
    afterglow_close(stream);
    return failed;
}
