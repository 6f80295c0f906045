#ifndef EQUISTREAM_CLIENT_H
#define EQUISTREAM_CLIENT_H
/*
 * The C ABI of libequistream_client: open a stream, say where the head is, get what both eyes see.
 *
 *     es_client_open            a file, a folder of rendered frames, or a server (tcp://, tls:// or srt://)
 *     es_client_render          both eyes into memory, at a display time, for a head
 *     es_client_draw            both eyes into framebuffers of the caller's OpenGL 4.5 context
 *     es_client_send_head       tells a live server where the head is
 *     es_client_close
 *
 * client.hpp wraps this for C++. docs/guide/show.md explains each step.
 *
 * Conventions: conventions.h. Lengths in metres, angles in radians, times in seconds. A camera looks along -z, +x is
 * right and +y is up. Quaternions have length 1 within 0.001, and no coordinate is beyond 1e9. Pictures are sRGB,
 * display-referred. In memory the first row is the top one; in a framebuffer the last one is, y + height - 1.
 * Struct growth: a struct that the caller fills begins with its own size. Fields are only ever appended. Those that an
 * older caller does not know of are taken to be 0. Structs that a call takes two of do not grow.
 * Threading: a client is used by one thread at a time. es_client_now_s and es_client_send_head may be called by any
 * thread meanwhile. The client reads and decodes in a thread of its own. Work on pictures uses all cores.
 * OpenGL: with ES_BACKEND_OPENGL one context is current in every call, open and close too: OpenGL 4.5 core with
 * GL_ARB_shader_viewport_layer_array and GL_ARB_indirect_parameters. The client loads functions by libepoxy. It takes
 * the context's pending errors: a host that looks for its own asks before it calls.
 * Ownership: the client copies texts, which have 65,536 bytes at most. What a function gives out belongs to the client,
 * where it does not say otherwise.
 * Errors: nothing throws, exits or prints. Calls that can fail take an optional es_error, filled on failure.
 * Logs: the first client turns libav's log off in the whole process. A host that has set another level than libav's
 * default, AV_LOG_INFO, keeps its own.
 */
#include <equistream/abi_types.h>

#ifdef __cplusplus
extern "C" {
#endif

#define ES_CLIENT_ABI_VERSION 1u

/* Who makes the eyes' pictures. Without a scene both show the same but for rounding. With one they also differ at
 * silhouettes, by up to a pixel of the source: the one casts depth, the other draws it. ES_BACKEND_OPENGL has no engine
 * splat and no fill passes small-wide, geometry and spread. With a scene its engines are eye-depth and rotation. What
 * it does not have is refused when a client is opened. */
typedef enum es_backend { ES_BACKEND_CPU = 0, ES_BACKEND_OPENGL = 1 } es_backend;

typedef struct es_client_settings {
    size_t struct_size;   /* sizeof(es_client_settings) */
    uint32_t abi_version; /* ES_CLIENT_ABI_VERSION */
    es_backend backend;
    const char* source; /* a file, a folder or a URL */
    /* Scene description, or a client's model of it, whose geometry gives depth. NULL: the stream's own depth is used.
     * ES_BACKEND_CPU loads the Embree module then. */
    const char* scene;
    /* As in `equistream play`, where the guide explains each. NULL: what suits the source best. */
    const char* engine;  /* rotation, mesh, eye-depth, ... */
    const char* fill;    /* passes that fill gaps, in order: "hidden,patches,earlier,base,pushpull"; "none" */
    const char* mirrors; /* images, gaps or surface */
    int32_t confidence;  /* non-zero: how far each pixel can be trusted is estimated */
    int32_t paused;      /* non-zero: begins with a still picture */
    int32_t loop;        /* non-zero: a recorded source starts again at its end */
    int32_t software;    /* non-zero: decoding never uses hardware */
    /* Moving objects are shown at most so much later than in the newest frame that came, by their motion: 0 to 1. 0:
     * where that frame shows them. */
    double max_extrapolation_s;
    double exposure_stops; /* -20 to 20, of an HDR stream; 0 for any other source */
} es_client_settings;

/* What was opened. */
typedef struct es_client_source {
    size_t struct_size;
    int32_t is_live;   /* non-zero: a server's; frames come when they come */
    int32_t has_poses; /* zero: ordinary video; eyes can turn and not move */
    int32_t has_depth; /* zero: no depth came, or the engine needs none */
    int32_t width, height;
    double frames_per_second;
    double ipd_m;             /* that the frames are tagged with */
    double head_box_radius_m; /* around each frame's centre: how far eyes may be for the promised accuracy */
    double first_time_s;      /* of the source */
    es_pose first_head;       /* of the first frame: where looking around may begin */
    char engine[32];          /* that was chosen */
} es_client_source;

/* Angles from the middle of a view, each within 85 degrees of it; left and down are negative, as in OpenXR. Right is
 * above left by 0.001 at least, and up above down. */
typedef struct es_field_of_view {
    double left, right, up, down;
} es_field_of_view;

typedef struct es_eye_view {
    es_pose in_head; /* head from eye: ipd/2 to the left or right, mostly */
    es_field_of_view fov;
} es_eye_view;

typedef struct es_client_request {
    size_t struct_size;
    /* When it will be seen, on the clock of es_client_now_s, 0 to 1e9. It ascends: one before the last counts as the
     * last. */
    double display_s;
    es_pose head;          /* world from head, at that time */
    es_eye_view eyes[2];   /* left and right */
    int32_t width, height; /* most pixels that an eye's picture may have, 1 to 16,384 */
} es_client_request;

typedef enum es_pixel_format {
    ES_RGBA8 = 0,    /* 4 bytes a pixel */
    ES_RGBA_HALF = 1 /* 8 bytes a pixel, the same values as 0 to 1 */
} es_pixel_format;

/* What gave a pixel its colour: the values of es_eye_image.origin. */
typedef enum es_origin {
    ES_ORIGIN_GAP = 0,        /* nothing; all four channels are 0 */
    ES_ORIGIN_SOURCE = 1,     /* the sphere itself, or the window of one */
    ES_ORIGIN_SMALL = 2,      /* the small second-eye view */
    ES_ORIGIN_NEIGHBOURS = 3, /* the pixels around */
    ES_ORIGIN_EARLIER = 4,    /* an earlier frame */
    ES_ORIGIN_PATCHES = 5,    /* patches that the server predicted */
    ES_ORIGIN_HIDDEN = 6,     /* the sphere's hidden layer */
    ES_ORIGIN_GEOMETRY = 7,   /* the scene's geometry */
    ES_ORIGIN_PUSH_PULL = 8,  /* coarser levels of the picture */
    ES_ORIGIN_BASE = 9        /* the coarse sphere around a window */
} es_origin;

/* One eye's picture in the caller's memory. The caller gives planes of request.width x request.height pixels at least;
 * NULL: not wanted. Row strides are in bytes, a row at least; 0: rows of request.width follow each other. */
typedef struct es_eye_image {
    size_t struct_size;
    es_pixel_format format;
    void* pixels;
    size_t pixels_stride;
    uint8_t* origin; /* es_origin */
    size_t origin_stride;
    float* depth_m;      /* along each pixel's ray; +inf: nothing is there; NaN: not known */
    size_t depth_stride; /* a multiple of 4 */
    uint8_t* confidence; /* 255 times the probability that no channel is off by more than 10 of 255 */
    size_t confidence_stride;
    /* Filled: what the picture is of. Square pixels and whole ones: it may show a little more than the field of view
     * that was asked for. It never has more pixels than there is room for. */
    int32_t width, height;
    es_field_of_view fov;
} es_eye_image;

/* Where an eye's picture is drawn: a rectangle of the caller's framebuffer, in all colour buffers that it draws to.
 * None of them has an integer format. What is known of the pixels may go to the caller's textures. */
typedef struct es_gl_target {
    size_t struct_size;
    uint32_t framebuffer;  /* 0: the window's */
    int32_t x, y;          /* lower left corner, -65,536 to 65,536 */
    int32_t width, height; /* filled: pixels that were drawn */
    es_field_of_view fov;  /* filled: as in es_eye_image */
    /* The caller's textures for what is known of each pixel: GL_TEXTURE_2D with immutable storage of request.width x
     * request.height texels at least, rows downwards from texel 0, 0. 0: not wanted. */
    uint32_t origin;     /* GL_R8UI: es_origin */
    uint32_t depth_m;    /* GL_R32F: along each pixel's ray; +inf: nothing is there; NaN: not known */
    uint32_t confidence; /* GL_R8; needs a client that was opened with confidence */
} es_gl_target;

/* The client's own textures of the last draw or render, arrays with a layer for each eye, rows downwards; 0: there is
 * none. They stay as they are until the next call. The host reads them, and neither writes to them nor deletes them.
 * The part of each eye: columns from x on, rows from y on. */
typedef struct es_gl_textures {
    size_t struct_size;
    uint32_t colour; /* GL_RGBA8 */
    uint32_t origin; /* GL_R8UI: es_origin */
    /* GL_R32F, or with a scene GL_DEPTH_COMPONENT32F. Times inverse_depth_scale: 1 / planar depth in metres; 0:
     * infinitely far; NaN: not known. */
    uint32_t inverse_depth;
    uint32_t confidence; /* GL_R8 */
    float inverse_depth_scale;
    int32_t x[2], y[2], width[2], height[2];
} es_gl_textures;

/* What is shown since the last es_client_render or es_client_draw. */
typedef struct es_client_state {
    size_t struct_size;
    int64_t frame;          /* index in the source */
    double time_s;          /* of the source, that is shown */
    es_pose head;           /* that the frame was rendered for */
    double extrapolation_s; /* moving objects are shown so much later than in the frame */
    double fraction_done;   /* 0 to 1; 0 where the end is not known */
    double overdue_s;       /* of a live source: for how long the next frame has been missing; 0: it is not */
    double playout_delay_s; /* of a live source: frames are shown so long after they were made */
    int32_t is_new;         /* non-zero: another frame than at the last call */
    int32_t is_over;        /* non-zero: the source has ended */
    int32_t is_paused;
    int32_t is_lost;        /* non-zero: the server is lost, and is being tried again */
    int32_t is_outside_box; /* non-zero: an eye left the head box: accuracy is not promised there */
} es_client_state;

typedef struct es_client_statistics {
    size_t struct_size;
    int64_t frames_received, frames_shown, pictures_rendered; /* since it was opened; a picture has both eyes */
    int64_t bytes_received;                                   /* of frames that came whole */
    int64_t reconnections;
    /* Means: a frame's, both eyes'. Of es_client_draw the time to give OpenGL its commands, not the GPU's. */
    double decode_ms, render_ms;
    /* Of the last picture of es_client_render, as it was handed out. es_client_draw leaves both as they are. */
    double mean_confidence; /* 0 to 1; 0 where it was not asked for */
    double gaps;            /* share of pixels that the source did not see */
} es_client_statistics;

typedef struct es_client es_client;

/* The version this library was built with; a caller refuses another one. */
ES_API uint32_t es_client_abi_version(void);
/* Such as "0.1.0"; static storage. */
ES_API const char* es_client_version(void);

/* Opens a source and waits for its first frame, for 60 s at most. Frames of other sizes than they are tagged with are
 * passed over until then. A server is given up sooner: after 10 s without a connection, 30 s without a first byte, or
 * 10 s without another. How long its name is looked up is the system's choice. Checks every setting. The caller closes
 * *client. */
ES_API es_status es_client_open(const es_client_settings* settings, es_client** client, es_error* error);
/* Ends reading and frees the client. NULL is allowed. */
ES_API void es_client_close(es_client* client);
ES_API es_status es_client_get_source(const es_client* client, es_client_source* source, es_error* error);

/* The clock of display times: seconds since the client was opened. Any thread. */
ES_API double es_client_now_s(const es_client* client);

/* Takes the frame that is due at the request's time, and renders what both eyes see of it into memory. `images`: left
 * and right. `state` may be NULL. With either back end.
 * ES_FAILED says why that frame cannot be shown. The frame before is shown again, and `images` and `state` are filled.
 * The next call goes on with the next frame. Where not even the frame before can be rendered, both stay as they were.
 * Then the next call tries what was due once more. But where a recorded source cannot be read the client is paused:
 * es_client_seek beyond that place and es_client_play go on. */
ES_API es_status es_client_render(es_client* client, const es_client_request* request, es_eye_image images[2],
                                  es_client_state* state, es_error* error);
/* The same into framebuffers. ES_BACKEND_OPENGL only. Targets are checked before anything is done. Every call leaves
 * the context's state as it was, but for these bindings: of textures, samplers and images to their units, and of
 * buffers to numbered binding points. Conditional rendering, occlusion queries and transform feedback are off
 * meanwhile. */
ES_API es_status es_client_draw(es_client* client, const es_client_request* request, es_gl_target targets[2],
                                es_client_state* state, es_error* error);
/* ES_BACKEND_OPENGL only, after es_client_draw or es_client_render. */
ES_API es_status es_client_get_textures(es_client* client, es_gl_textures* textures, es_error* error);

/* Where the head is now, in the world, for a server that renders from there, or sends the tiles that are looked at. The
 * field of view of the last render or draw goes with it. At most 30 of these a second are sent, and none twice. Of
 * other sources nothing is done. Any thread. */
ES_API es_status es_client_send_head(es_client* client, const es_pose* head, es_error* error);

/* A live source goes on meanwhile: playing again shows what it shows by then. */
ES_API void es_client_pause(es_client* client);
ES_API void es_client_play(es_client* client);
/* Of a recorded source: the first frame at this time or after it is shown next. */
ES_API es_status es_client_seek(es_client* client, double time_s, es_error* error);

ES_API es_status es_client_get_statistics(const es_client* client, es_client_statistics* statistics, es_error* error);

/* Both eyes of an ordinary display: `eyes` get the field of view `fov_x_rad` wide with square pixels of width x height,
 * and poses ipd_m apart. The first is 0.001 to 2.96, which is 170 degrees; the second is 0 to 10. A picture so high
 * that the field of view reaches more than 85 degrees up is refused when it is rendered. */
ES_API es_status es_client_set_eyes(es_client_request* request, double fov_x_rad, double ipd_m, es_error* error);

#ifdef __cplusplus
}
#endif
#endif
