/* SPDX-License-Identifier: Apache-2.0 */
/* Prints the depth at the centre of each frame. An argument names another bus than the system's. */
#include <afterglow/afterglow.h>
#include <stdio.h>
#include <stdlib.h>

static int print_frames(struct afterglow_stream *stream) {
    struct afterglow_info info = {.size = sizeof info};
    afterglow_get_info(stream, &info);
    size_t bytes = afterglow_plane_bytes(stream, AFTERGLOW_PLANE_DEPTH);
    uint16_t *depth = malloc(bytes);
    if (depth == NULL)
        return -1;
    const struct afterglow_buffer want = {AFTERGLOW_PLANE_DEPTH, 0, depth, bytes};
    const size_t centre = (size_t)info.height / 2 * info.width + info.width / 2;

    int error;
    while ((error = afterglow_wait(stream, -1)) == 0) {
        struct afterglow_frame frame = {.size = sizeof frame};
        if (afterglow_read_latest(stream, &frame, &want, 1) == 0)
            printf("frame %llu: %u mm\n", (unsigned long long)frame.index, (unsigned)depth[centre]);
    }
    free(depth);
    return error;
}

int main(int argc, char **argv) {
    struct afterglow_options options = {.size = sizeof options, .bus = argc > 1 ? argv[1] : NULL};
    struct afterglow_stream *stream;
    int error = afterglow_open(&options, &stream);
    if (error == 0)
        error = print_frames(stream);
    afterglow_close(stream);
    fprintf(stderr, "%s\n", afterglow_strerror(error));
    return EXIT_FAILURE;
}
