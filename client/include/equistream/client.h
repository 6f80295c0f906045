#ifndef EQUISTREAM_CLIENT_H
#define EQUISTREAM_CLIENT_H
/*
 * The C ABI of libequistream_client: open a stream, say where the head is, get what both eyes see.
 *
 *     es_client_open            a file, a folder of rendered frames, or a server (tcp://, tls:// or srt://)
 *     es_client_render          both eyes into memory, at a display time, for a head
 *     es_client_draw            both eyes into framebuffers of the caller's OpenGL 4.5 context
 *     es_client_send_head       sends the head's pose to a live server
 *     es_client_close
 *
 * client.hpp wraps this for C++. docs/guide/show.md explains each step.
 *
 * Conventions: conventions.h. Lengths in metres, angles in radians, times in seconds. A camera looks along -z, +x is
 * right and +y is up. Quaternions have length 1 within 0.001, and no coordinate is beyond 1e9. Pictures are sRGB,
 * display-referred. In memory the first row is the top one; in a framebuffer the top row is y + height - 1.
 * Struct growth: a struct that the caller fills begins with its own size. Fields are only ever appended. Fields missing
 * from an older caller's struct count as 0. es_eye_image and es_gl_target, which are passed in pairs, never grow.
 * Threading: a client is used by one thread at a time. es_client_now_s and es_client_send_head may be called by any
 * thread meanwhile, but not during es_client_close. The client reads and decodes in a thread of its own. Work on
 * pictures uses all cores.
 * OpenGL: with ES_BACKEND_OPENGL one context is current in every call, open and close too: OpenGL 4.5 core with
 * GL_ARB_shader_viewport_layer_array and GL_ARB_indirect_parameters. The client loads functions by libepoxy. It clears
 * the context's error flags: a host that wants its own errors calls glGetError before it calls the client.
 * Ownership: texts are copied; they have at most 65,536 bytes. The client writes only into memory, framebuffers and
 * textures that the caller passes. Textures of es_client_get_textures belong to the client.
 * Errors: nothing throws, exits or prints. `error` may be NULL; a call fills it when it fails.
 * Logs: the first client turns libav's log off in the whole process. A host that has set another level than libav's
 * default, AV_LOG_INFO, keeps its own. The first srt:// client turns libsrt's log off in the whole process.
 */
#include <equistream/abi_types.h>

#ifdef __cplusplus
extern "C" {
#endif

#define ES_CLIENT_ABI_VERSION 1u

/* What renders the eyes' pictures: the processor, or OpenGL in the caller's context. Without a scene both give the same
 * picture up to rounding. With a scene they also differ at silhouettes, by up to a pixel of the source: the CPU casts
 * rays for depth, OpenGL rasterises it. ES_BACKEND_OPENGL has no engine splat and no fill passes small-wide, geometry
 * and spread. With a scene its engines are eye-depth and rotation. es_client_open refuses what a back end lacks. */
typedef enum es_backend { ES_BACKEND_CPU = 0, ES_BACKEND_OPENGL = 1 } es_backend;

typedef struct es_client_settings {
    size_t struct_size;   /* sizeof(es_client_settings) */
    uint32_t abi_version; /* ES_CLIENT_ABI_VERSION */
    es_backend backend;
    /* Path of a file or a folder, or tcp://HOST:PORT, tls://[SECRET@]HOST:PORT, srt://[SECRET@]HOST:PORT[?parity=N].
     * Without SECRET the environment variable EQUISTREAM_SECRET gives it. Not NULL or empty. */
    const char* source;
    /* Path of a scene description, or a client's model of it, whose geometry gives depth. NULL: the stream's own depth
     * is used. ES_BACKEND_CPU loads the Embree module for a scene. */
    const char* scene;
    /* NULL: the default for the source. docs/guide/play.md explains each value. */
    const char* engine;  /* `--method` of `equistream play`: rotation, proxy-sphere, eye-depth, mesh, splat, ... */
    const char* fill;    /* passes that fill gaps, in order, such as "hidden,patches,earlier,base,pushpull"; "none" */
    const char* mirrors; /* treatment of reflections: images, gaps or surface */
    int32_t confidence;  /* non-zero: estimates the confidence map, `--reliability` of `equistream play` */
    int32_t paused;      /* non-zero: starts paused on the first frame */
    int32_t loop;        /* non-zero: a recorded source starts again at its end */
    int32_t software;    /* non-zero: decodes without hardware */
    /* Motion extrapolation: moving objects are shown at most so many seconds later than in the newest received frame; 0
     * to 1. 0: where that frame shows them. */
    double max_extrapolation_s;
    double exposure_stops; /* exposure of an HDR stream, -20 to 20; other sources are refused unless it is 0 */
} es_client_settings;

/* Properties of the opened source. */
typedef struct es_client_source {
    size_t struct_size;    /* sizeof(es_client_source), set by the caller */
    int32_t is_live;       /* non-zero: a server sends frames at its own pace */
    int32_t has_poses;     /* zero: ordinary video without poses; eyes turn and do not move */
    int32_t has_depth;     /* non-zero: the chosen engine reprojects by depth, of the source or the scene */
    int32_t width, height; /* pixels of the first frame; of one eye where a picture holds both */
    double frames_per_second;
    double ipd_m;             /* interpupillary distance in the first frame's tags */
    double head_box_radius_m; /* accuracy holds for eyes within this distance of each frame's camera */
    double first_time_s;      /* time of the first frame, on the source's clock */
    es_pose first_head;       /* world from head, of the first frame: where viewing may begin */
    char engine[32];          /* name of the engine in use, NUL-terminated */
} es_client_source;

/* Angles from the view's axis, each from -85 to 85 degrees (1.48 rad); left and down are negative, as in OpenXR's
 * XrFovf. right exceeds left by at least 0.001, and up exceeds down by as much. */
typedef struct es_field_of_view {
    double left, right, up, down;
} es_field_of_view;

typedef struct es_eye_view {
    es_pose in_head; /* head from eye: usually ipd/2 along -x (left) or +x (right) */
    es_field_of_view fov;
} es_eye_view;

typedef struct es_client_request {
    size_t struct_size; /* sizeof(es_client_request) */
    /* When the picture will be seen, on the clock of es_client_now_s, 0 to 1e9. Times ascend: an earlier time than the
     * last call's counts as that one. */
    double display_s;
    es_pose head;          /* world from head, predicted for display_s */
    es_eye_view eyes[2];   /* left and right */
    int32_t width, height; /* largest size of each eye's picture in pixels, 1 to 16,384 */
} es_client_request;

typedef enum es_pixel_format {
    ES_RGBA8 = 0,    /* 4 bytes a pixel, 0 to 255 */
    ES_RGBA_HALF = 1 /* 8 bytes a pixel: the same values over 255, as IEEE half floats */
} es_pixel_format;

/* What gave a pixel its colour: the values of es_eye_image.origin. */
typedef enum es_origin {
    ES_ORIGIN_GAP = 0,        /* nothing; all four channels are 0 */
    ES_ORIGIN_SOURCE = 1,     /* the sphere itself, or its window */
    ES_ORIGIN_SMALL = 2,      /* the small second-eye view */
    ES_ORIGIN_NEIGHBOURS = 3, /* the nearest filled pixels (pass spread) */
    ES_ORIGIN_EARLIER = 4,    /* an earlier frame */
    ES_ORIGIN_PATCHES = 5,    /* patches that the server predicted */
    ES_ORIGIN_HIDDEN = 6,     /* the sphere's hidden layer */
    ES_ORIGIN_GEOMETRY = 7,   /* the scene's geometry */
    ES_ORIGIN_PUSH_PULL = 8,  /* coarser levels of the picture */
    ES_ORIGIN_BASE = 9        /* the coarse sphere around a window */
} es_origin;

/* One eye's picture in the caller's memory. Each plane has room for request.width x request.height pixels; NULL: not
 * wanted. Strides are in bytes from row to row, at least a row of request.width pixels; 0: exactly such a row. */
typedef struct es_eye_image {
    size_t struct_size;     /* sizeof(es_eye_image), exactly */
    es_pixel_format format; /* of `pixels` */
    void* pixels;           /* red, green, blue, alpha; sRGB; alpha 0 in gaps */
    size_t pixels_stride;
    uint8_t* origin; /* es_origin */
    size_t origin_stride;
    float* depth_m;      /* metres along each pixel's ray; +inf: no surface; NaN: unknown */
    size_t depth_stride; /* a multiple of 4 */
    /* 255 times the probability that no channel is off by more than 10 of 255; 0 if the client was opened without
     * confidence (docs/conventions.md, "Confidence"). */
    uint8_t* confidence;
    size_t confidence_stride;
    /* Filled by the call: size and field of view of the picture. Pixels are square, so it may show a little more than
     * the field of view that was requested, in at most request.width x request.height pixels. */
    int32_t width, height;
    es_field_of_view fov;
} es_eye_image;

/* Where an eye's picture is drawn: a rectangle in every colour buffer that the caller's framebuffer draws to. The
 * framebuffer is complete and has no integer colour buffers. */
typedef struct es_gl_target {
    size_t struct_size;    /* sizeof(es_gl_target), exactly */
    uint32_t framebuffer;  /* name of a framebuffer object; 0: the window's */
    int32_t x, y;          /* lower left corner in pixels, -65,536 to 65,536 */
    int32_t width, height; /* filled by the call: pixels that were drawn */
    es_field_of_view fov;  /* filled by the call: as in es_eye_image */
    /* The caller's textures for planes beside colour: GL_TEXTURE_2D with immutable storage of at least request.width x
     * request.height texels; the top row goes to texel row 0. 0: not wanted. */
    uint32_t origin;     /* GL_R8UI: es_origin */
    uint32_t depth_m;    /* GL_R32F: metres along each pixel's ray; +inf: no surface; NaN: unknown */
    uint32_t confidence; /* GL_R8: the probability; needs a client that was opened with confidence */
} es_gl_target;

/* The client's own textures of the last draw or render: GL_TEXTURE_2D_ARRAY, layer 0 for the left eye and 1 for the
 * right, top row first; 0: not available. They are valid and unchanged until the next es_client_render, es_client_draw
 * or es_client_close. The host reads them, and neither writes to them nor deletes them. An eye's picture is the
 * rectangle of width x height texels at column x, row y. */
typedef struct es_gl_textures {
    size_t struct_size; /* sizeof(es_gl_textures) */
    uint32_t colour;    /* GL_RGBA8, sRGB values */
    uint32_t origin;    /* GL_R8UI: es_origin */
    /* GL_R32F, or with a scene GL_DEPTH_COMPONENT32F. The sample times inverse_depth_scale is 1 / planar depth in
     * metres; 0: infinitely far; NaN: unknown. */
    uint32_t inverse_depth;
    uint32_t confidence; /* GL_R8; 0 without confidence */
    float inverse_depth_scale;
    int32_t x[2], y[2], width[2], height[2]; /* left and right */
} es_gl_textures;

/* State of the picture that the call rendered. */
typedef struct es_client_state {
    size_t struct_size;     /* sizeof(es_client_state) */
    int64_t frame;          /* index of the frame shown */
    double time_s;          /* time shown, on the source's clock */
    es_pose head;           /* world from head for which the frame was rendered */
    double extrapolation_s; /* how much later than in the frame moving objects are shown */
    double fraction_done;   /* 0 to 1; 0 where the end is not known */
    double overdue_s;       /* live source: how long the next frame has been missing; 0: it is not */
    double playout_delay_s; /* live source: play-out delay beyond the path's smallest delay, to absorb jitter; else 0 */
    int32_t is_new;    /* non-zero: another frame than at the last call; zero for the frame that es_client_open read */
    int32_t is_over;   /* non-zero: the source has ended */
    int32_t is_paused; /* non-zero: paused by the caller, or because a recorded source cannot be read */
    int32_t is_lost;   /* non-zero: the connection is lost, and the client is reconnecting */
    int32_t is_outside_box; /* non-zero: an eye left the head box, where accuracy is not promised */
} es_client_state;

typedef struct es_client_statistics {
    size_t struct_size; /* sizeof(es_client_statistics) */
    /* Counted since es_client_open. A picture holds both eyes. */
    int64_t frames_received, frames_shown, pictures_rendered;
    int64_t bytes_received; /* coded bytes of the complete frames */
    int64_t reconnections;
    /* Mean milliseconds: to decode a frame shown, to render both eyes. With es_client_draw render_ms is the time to
     * issue the OpenGL commands, not the GPU's. */
    double decode_ms, render_ms;
    /* Both describe the last picture of es_client_render, as it was handed out. es_client_draw leaves them unchanged.
     */
    double mean_confidence; /* 0 to 1; 0 if the client was opened without confidence */
    double gaps;            /* share of pixels, 0 to 1, whose origin is not ES_ORIGIN_SOURCE, filled or not */
} es_client_statistics;

typedef struct es_client es_client;

/* ES_CLIENT_ABI_VERSION of the library's own build; a caller refuses a library with another version. Any thread. */
ES_API uint32_t es_client_abi_version(void);
/* Version of the library, such as "0.1.0"; static storage. Any thread. */
ES_API const char* es_client_version(void);

/* Opens a source and waits for its first frame, for 60 s at most. Until then it skips frames whose size is not the one
 * in their tags. Connecting to a server fails sooner: after 10 s without a connection, 30 s without a first byte, or
 * 10 s without another. The system limits the look-up of the server's name. Checks every setting. The caller closes
 * *client, which is NULL on failure. */
ES_API es_status es_client_open(const es_client_settings* settings, es_client** client, es_error* error);
/* Stops reading and frees the client. NULL is allowed. */
ES_API void es_client_close(es_client* client);
/* Fills *source, whose struct_size the caller has set. */
ES_API es_status es_client_get_source(const es_client* client, es_client_source* source, es_error* error);

/* The clock of display times: seconds since the client was opened, monotonic. 0 for NULL. Any thread. */
ES_API double es_client_now_s(const es_client* client);

/* Selects the frame that is due at the request's time, and renders both eyes' views of it into `images`, left and
 * right. `state` may be NULL. Works with either back end.
 * ES_FAILED: the due frame cannot be shown, and `error` says why. The previous frame is shown again, and `images` and
 * `state` are filled. The next call continues with the next frame. If the previous frame cannot be rendered either,
 * `images` and `state` are unchanged, and the next call tries the due frame again. If a recorded source cannot be read,
 * the client pauses: es_client_seek past that place, then es_client_play. */
ES_API es_status es_client_render(es_client* client, const es_client_request* request, es_eye_image images[2],
                                  es_client_state* state, es_error* error);
/* The same into framebuffers; ES_BACKEND_OPENGL only. Targets are checked before anything is drawn. Writes sRGB values
 * as they are, also to sRGB attachments. Pixels beyond the picture's width and height stay unchanged. Every call with
 * that back end restores the context's state. Exceptions are the bindings of textures, samplers and images to units,
 * and of buffers to indexed binding points. The host must not call with conditional rendering, an occlusion query or
 * transform feedback active. */
ES_API es_status es_client_draw(es_client* client, const es_client_request* request, es_gl_target targets[2],
                                es_client_state* state, es_error* error);
/* Fills *textures, whose struct_size the caller has set. ES_BACKEND_OPENGL only; ES_BAD_INPUT unless the last
 * es_client_draw or es_client_render made both pictures. */
ES_API es_status es_client_get_textures(es_client* client, es_gl_textures* textures, es_error* error);

/* Sends the head's current pose, world from head, to a live server, which renders from there or sends the tiles in
 * view. The field of view of the last render or draw goes with it. Sends at most 30 poses a second, and skips a
 * repeated one. No effect on other sources. Any thread. */
ES_API es_status es_client_send_head(es_client* client, const es_pose* head, es_error* error);

/* Holds the picture, or lets it go on. A live source continues meanwhile: after es_client_play it shows its present.
 * After the end es_client_play starts a recorded source again and reconnects to a server; a pipe stays over. NULL is
 * allowed. */
ES_API void es_client_pause(es_client* client);
ES_API void es_client_play(es_client* client);
/* Shows the first frame at or after `time_s` next, paused or not. `time_s` is on the source's clock, from -1e12 to
 * 1e12. ES_BAD_INPUT for a live source and for a pipe. */
ES_API es_status es_client_seek(es_client* client, double time_s, es_error* error);

/* Fills *statistics, whose struct_size the caller has set. */
ES_API es_status es_client_get_statistics(const es_client* client, es_client_statistics* statistics, es_error* error);

/* Fills `request->eyes` for an ordinary display: both get a symmetric field of view, `fov_x_rad` wide, with square
 * pixels of width x height, and poses ipd_m apart. request->width and height are set before. fov_x_rad is 0.001 to
 * 2.96 (170 degrees), ipd_m 0 to 10. Rendering refuses a picture so high that it reaches more than 85 degrees up. */
ES_API es_status es_client_set_eyes(es_client_request* request, double fov_x_rad, double ipd_m, es_error* error);

#ifdef __cplusplus
}
#endif
#endif
