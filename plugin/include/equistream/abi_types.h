#ifndef EQUISTREAM_ABI_TYPES_H
#define EQUISTREAM_ABI_TYPES_H
/*
 * What the C ABIs of libequistream (equistream.h) and of libequistream_client (client.h) share. Lengths in metres,
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
    ES_FAILED = 1,    /* work could not be finished: disk full, I/O error */
    ES_BAD_INPUT = 2, /* an argument is wrong; nothing was done */
    ES_DONE = 3       /* no more tiles */
} es_status;

typedef struct es_error {
    char text[1024]; /* one line, NUL-terminated */
} es_error;

typedef enum es_eye { ES_EYE_CENTRE = 0, ES_EYE_LEFT = 1, ES_EYE_RIGHT = 2 } es_eye;

/* World from head. */
typedef struct es_pose {
    double position_m[3];
    double orientation_wxyz[4]; /* unit quaternion */
} es_pose;

#endif
