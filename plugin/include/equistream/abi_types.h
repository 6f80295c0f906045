#ifndef EQUISTREAM_ABI_TYPES_H
#define EQUISTREAM_ABI_TYPES_H
/*
 * Types shared by the C ABIs of libequistream (equistream.h) and libequistream_client (client.h). Lengths in metres,
 * angles in radians, quaternions as w, x, y, z.
 */
#include <stddef.h>
#include <stdint.h>

#if defined(EQUISTREAM_BUILDING)
#define ES_API __attribute__((visibility("default")))
#else
#define ES_API
#endif

typedef enum es_status {
    ES_OK = 0,
    ES_FAILED = 1,    /* work had begun and could not be finished: disk full, I/O error, out of memory */
    ES_BAD_INPUT = 2, /* an argument or a file is wrong; the call had no effect, except that es_frame_end frees its
                       * frame */
    ES_DONE = 3       /* es_frame_next_tile: no more tiles */
} es_status;

/* In the caller's memory. Calls write it when they fail, and leave it unchanged when they succeed. */
typedef struct es_error {
    char text[1024]; /* one line, NUL-terminated; longer messages are cut */
} es_error;

typedef enum es_eye { ES_EYE_CENTRE = 0, ES_EYE_LEFT = 1, ES_EYE_RIGHT = 2 } es_eye;

/* Transform from the axes of a head, eye or camera to the world, or to the axes that a field names. */
typedef struct es_pose {
    double position_m[3];       /* x, y, z, each from -1e9 to 1e9 */
    double orientation_wxyz[4]; /* unit quaternion; its length is within 0.001 of 1 and is normalised */
} es_pose;

#endif
