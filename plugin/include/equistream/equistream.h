#ifndef EQUISTREAM_EQUISTREAM_H
#define EQUISTREAM_EQUISTREAM_H
/*
 * The C ABI by which any renderer (a host) loads libequistream. The plugin owns the cameras, the film, the AOVs and
 * the export; the host traces rays. A host answers in two ways, which may be mixed within one frame:
 *
 *   rays    loop over es_frame_next_tile; for each tile ask for the geometry rays (one per pixel, through its centre)
 *           and for `sample_count` sets of colour rays (one jittered ray per pixel each), and hand answers back;
 *   planes  hand over whole planes by AOV name with es_frame_put_plane.
 *
 * Conventions: conventions.h. Lengths in metres, angles in radians, times in seconds. Colour is linear Rec.709,
 * scene-referred. Pixels run row by row from the top left.
 * Struct growth: every struct that a host fills and passes by one pointer begins with struct_size, its own size. Fields
 * are only ever appended. Fields missing from an older host's struct count as 0.
 * Threading: a sequence may be used by one thread at a time. es_frame_next_tile and all es_tile_* calls of one frame
 * may run on any number of threads, each tile on one thread at a time. es_frame_end reports misuse of a call that
 * returns no status: a tile of another frame, NULL, too many passes.
 * Ownership: the library copies everything that a host passes. Pointers need to be valid only until the call returns.
 * The host allocates the arrays of rays and answers.
 * Errors: nothing throws, exits or prints. `error` may be NULL; a call fills it when it fails.
 */
#include <equistream/abi_types.h>

#ifdef __cplusplus
extern "C" {
#endif

#define ES_ABI_VERSION 3u

/* ES_ODS is omnidirectional stereo (image_motion.h; docs/conventions.md, "Omnidirectional stereo"): a sphere whose rays
 * begin on a circle of diameter ipd_m around the head, each at its own viewpoint. It needs ES_EYE_LEFT or ES_EYE_RIGHT.
 * Longitudes and latitudes are as for ES_EQUIRECT. It has no hidden layer, no atlas of patches, no windows and no
 * accumulated frames. */
typedef enum es_camera_kind { ES_EQUIRECT = 0, ES_PERSPECTIVE = 1, ES_ODS = 2 } es_camera_kind;
/* Orientation of a sphere: ES_LOCK_WORLD keeps the world's axes, ES_LOCK_PATH turns with the head. A perspective camera
 * always turns with the head. */
typedef enum es_axis_lock { ES_LOCK_WORLD = 0, ES_LOCK_PATH = 1 } es_axis_lock;
/* Which surface along each pixel's ray a sequence shows. ES_LAYER_HIDDEN: the nearest surface behind the first one that
 * an eye in the head box can see (docs/conventions.md, "Hidden layer"). */
typedef enum es_layer { ES_LAYER_FIRST = 0, ES_LAYER_HIDDEN = 1 } es_layer;

/* Quality of denoising by Intel's Open Image Denoise 2, applied before a frame is written. es_sequence_open looks for
 * the library in the system and in Python environments; the environment variable EQUISTREAM_OIDN overrides that.
 * Without it the call returns ES_BAD_INPUT. Times and errors: docs/results/denoise.md. */
typedef enum es_denoise {
    ES_DENOISE_OFF = 0,
    ES_DENOISE_FAST = 1,
    ES_DENOISE_BALANCED = 2,
    ES_DENOISE_HIGH = 3
} es_denoise;

/* Every number that is outside its range is refused with ES_BAD_INPUT. */
typedef struct es_sequence_settings {
    size_t struct_size;    /* sizeof(es_sequence_settings) */
    uint32_t abi_version;  /* ES_ABI_VERSION */
    uint32_t spp;          /* colour samples per pixel, 1 to 1,048,576 */
    uint64_t seed;         /* decides the sample positions and es_ray.seed; any value */
    es_camera_kind camera; /* projection of the frames */
    int32_t width, height; /* pixels, 1 to 32,768 each, 2^28 in all; a window's in a sequence of windows */
    double fov_x_rad;      /* horizontal field of view, 0.001 to pi - 0.001; perspective only */
    double longitude_min, longitude_max; /* ascending, -2 pi to 2 pi, 0.001 to 2 pi apart; both 0: the full circle.
                                          * Spheres only */
    double latitude_min, latitude_max;   /* ascending, -pi/2 to pi/2, 0.001 apart at least; both 0: pole to pole.
                                          * Spheres only */
    es_eye eye;                          /* where the camera is: the head's centre, or an eye beside it */
    es_axis_lock lock;                   /* axes of a sphere */
    double ipd_m;                        /* interpupillary distance, 0 to 10 */
    double head_radius_m;                /* head box: radius of the ball around each frame's head in which the head's
                                          * centre may be when the frame is shown; 0 to 1000 */
    double frames_per_second;            /* 0.001 to 1000 */
    double exposure;                     /* factor on radiance before the display transform, 1e-12 to 1e12; recorded in
                                          * the files, whose colours are not multiplied by it */
    const char* output_dir;              /* the sequence's folder, made if missing; not NULL or empty */
    /* AOV groups, separated by commas; not NULL. "all" stands for "depth,motion,normal,albedo,ids,specular,virtual",
     * "none" for colour alone. Other groups are added by name (aov.h). Plane "colour" is always written.
     * Group "reference" adds tiles of up to 4x4 pixels after all others. They have colour passes only: 64 spp, times
     * accumulate_frames if that is set, and at least 256. They take about 1/50 of the frame's samples, and there is at
     * least one. Encoders measure the visible errors of the finished picture there. */
    const char* aovs;
    const char* scene_name;  /* recorded in the files; UTF-8, at most 255 bytes; may be NULL */
    const char* host_name;   /* renderer, version, build: frames of another host are never mixed with this one's; UTF-8,
                              * at most 255 bytes; may be NULL */
    const char* command;     /* recorded in the manifest; at most 65,536 bytes; may be NULL */
    const char* fingerprint; /* names everything else that decides the pixels, such as a hash of the scene. A sequence
                              * with another one is not resumed. At most 65,536 bytes; may be NULL */
    int32_t overwrite;       /* non-zero: finished frames are rendered again; zero: they are kept (resume) */
    int32_t single_part;     /* non-zero: EXR files with one part and an additional plain channel Z; zero: two parts */
    /* Names the geometry alone: clients refuse a scene or model with another one. UTF-8, at most 255 bytes; may be
     * NULL. */
    const char* geometry_fingerprint;
    es_layer layer;    /* surfaces that the frames show */
    int32_t tile_side; /* largest width and height of a tile in pixels, 1 to 32,768; 0: 32 */
    /* An atlas of patches (docs/conventions.md, "Atlases of patches"): frames hold blocks of auxiliary spheres instead
     * of the sphere that all other fields describe. ES_EQUIRECT only; no motion planes and no hidden layer. patch_side:
     * pixels along a patch, 4 to 64; 0: no atlas. patch_columns x patch_rows: slots of the atlas, 1 to 12,288.
     * patch_offset_count: auxiliary spheres, 1 to 64. patch_offsets_m: their centres, x, y, z each, from the main
     * sphere's centre and in its axes. */
    int32_t patch_side, patch_columns, patch_rows;
    uint32_t patch_offset_count;
    const double* patch_offsets_m;
    /* Denoises plane "colour" in es_frame_end; group "raw" keeps the noisy colour. The denoiser takes guides from
     * es_tile_put_guides or from planes "guide_albedo" and "guide_normal", else from planes "albedo" and "normal". */
    es_denoise denoise;
    uint32_t denoise_threads; /* threads of a denoiser on the CPU, at most 4,096; 0: one per processor */
    /* 1 to 1,000: each frame's colour is the mean over this frame and the frames before it, found again by exact
     * motion (docs/conventions.md, "Accumulated frames"). Where anything moved, at most so many earlier frames count
     * (or more of what moves by less than 1/256 pixels).
     * 0: frames are independent.
     * A frame continues the mean of the frame that was ended last, if head_previous is that frame's head and `index` -
     * previous_frames its index. Any other frame begins a new mean, and so does a window that has moved. Tiles get
     * between half and four times spp, more where the mean is noisier; the average is spp. The mean needs the planes of
     * groups depth, motion, normal, ids, specular and virtual, written or not. Groups "samples" and "variance" describe
     * its quality. No hidden layer, no atlas. */
    uint32_t accumulate_frames;
    /* 32 to 32,768, a multiple of 16: each frame is a window, part of a full equirect sphere of so many
     * columns and half as many rows. width and height are the window's, in multiples of 16; es_frame_settings gives its
     * place. Its rays are the sphere's. 0: frames are no windows. Longitudes and latitudes are 0; no hidden layer, no
     * atlas. */
    int64_t window_columns;
    /* Non-zero: tiles of a sphere or a window get samples in proportion to the solid angle of their pixels: spp on the
     * equator, at least 1. So noise per solid angle is uniform, for 2/pi (0.64) of the samples of a full sphere.
     * Spheres only; no atlas, no accumulated frames. */
    int64_t samples_by_angle;
    /* 1 to 65,536: each frame is rendered in so many parts, each by a program of its own; 0: frames are rendered whole.
     * `part` is this program's part, from 1: only its tiles are handed out, and es_frame_end keeps their sums in a
     * subfolder of output_dir. With `part` 0 es_frame_begin reads all parts of the frame, no tile is handed out, and
     * es_frame_end writes the frame and removes its parts. Such a frame has the same bytes as one rendered whole.
     * Planes come by tiles only; no atlas, no accumulated frames, no es_frame_settings.window. */
    uint32_t part_count, part;
    /* Group "cryptomatte": names of the objects and materials with ids 1, 2 and so on. UTF-8, at most 65,536 bytes each
     * and 2^24 names; the arrays may be NULL if their count is 0. Ids beyond the count are called "object 7" or
     * "material 3"; a NULL or empty entry is an empty name. `fingerprint` has to cover the names. The group excludes a
     * hidden layer, an atlas, accumulated frames and es_frame_settings.window. */
    const char* const* object_names;
    const char* const* material_names;
    uint32_t object_name_count, material_name_count;
} es_sequence_settings;

/* Content of one slot of an atlas: a block of an auxiliary sphere. */
typedef struct es_patch {
    int32_t used; /* zero: the slot is empty and asks for no rays; the other fields are ignored */
    /* Auxiliary sphere, 0 to patch_offset_count - 1; column and row of the block, in units of patch_side pixels. */
    uint32_t offset_index, block_x, block_y;
} es_patch;

typedef struct es_sequence es_sequence;
typedef struct es_frame es_frame;

typedef struct es_frame_settings {
    size_t struct_size;                     /* sizeof(es_frame_settings) */
    int64_t index;                          /* number of the frame and of its file, 0 to 999,999,999 */
    double time_s;                          /* from -1e10 to 1e10 */
    es_pose head_previous, head, head_next; /* world from head; a missing neighbour: repeat `head` (no camera motion) */
    const es_patch* patches;                /* atlas only: its slots, row by row from the top left */
    size_t patch_count;                     /* patch_columns * patch_rows; 0 without an atlas */
    uint32_t spp;             /* accumulated frames only: samples per pixel of this frame; 0: the sequence's */
    uint32_t previous_frames; /* by how many frames head_previous and position_previous_m are earlier, at most
                               * 999,999,999; 0 means 1 */
    /* Sequence of windows: upper left corner of this window on its sphere, pixels, multiples of 16. x is 0 to
     * window_columns - 16, and the window may cross the seam. y is 0 to window_columns / 2 - height. Otherwise 0. */
    int32_t window_x, window_y;
    /* For a base, a frame of a full equirect sphere from -pi to pi: the sequence of windows on a denser sphere, with
     * the same eye, ipd_m and axes; NULL: no window. That sequence has either begun the frame of this index last, with
     * the same poses, or keeps it finished. It has to end that frame before es_frame_end of the base. Base pixels that
     * the window covers entirely get the mean of its finished colours. Tiles that it covers entirely have no colour
     * passes, unless frames are accumulated; planes "raw" and guides are not rendered there. es_frame_begin reads the
     * other sequence: no other thread may begin a frame of it meanwhile. */
    const es_sequence* window;
} es_frame_settings;

/* A rectangle of pixels to render. Filled by es_frame_next_tile; the host must not change it. Tiles of group
 * "reference" overlap other tiles. */
typedef struct es_tile {
    uint32_t id;
    int32_t x, y, width, height; /* pixels of the frame's picture; x, y is the upper left pixel */
    uint32_t pixel_count;  /* width * height: the most rays that any call fills; pixels run row by row, top down */
    uint32_t sample_count; /* colour passes; 0 where a window gives the colour */
} es_tile;

/* World space. */
typedef struct es_ray {
    float origin[3];     /* metres */
    float t_min;         /* metres; surfaces nearer than this do not count. 0 except in a hidden layer */
    float direction[3];  /* unit length */
    float t_max;         /* metres; +inf */
    uint64_t seed;       /* for the host's random numbers; differs for every (sequence seed, frame, pixel, sample) */
    float footprint_rad; /* square root of the pixel's solid angle, for texture filtering */
    uint32_t pixel;      /* index within the tile, 0 to pixel_count - 1 */
} es_ray;

/* The surface that a geometry ray hit. For a miss set distance_m to +inf and the rest to 0. */
typedef struct es_surface {
    float distance_m;             /* Euclidean, from the ray's origin */
    float position_previous_m[3]; /* world position of the same surface point at the previous frame */
    float position_next_m[3];     /* and at the next frame */
    float normal[3];              /* world, unit, facing the camera */
    float albedo[3];              /* diffuse albedo, specular colour of a metal; linear Rec.709, 0 to 1 */
    uint32_t object_id, material_id, instance_id; /* from 1 */
    /* 1 where over 3/4 of the light that the surface sends to the camera leaves as a sharp reflection or refraction,
     * else 0. */
    float specular;
    /* The image seen in a mirror or through glass (docs/conventions.md, "What a mirror or a pane shows"): its apparent
     * distance along the ray, +inf for an image at infinity. 0: the surface itself is seen. */
    float virtual_distance_m;
    float virtual_previous_m[3], virtual_next_m[3]; /* world position of that image at the previous and next frame */
} es_surface;

typedef enum es_sample_type { ES_FLOAT32 = 0, ES_UINT32 = 1 } es_sample_type;

/* A whole plane of a frame, of the size of its picture: width x height, or the atlas. */
typedef struct es_plane {
    size_t struct_size;      /* sizeof(es_plane) */
    const char* name;        /* AOV plane name: "colour", "depth", "backward", ... (aov.h) */
    es_sample_type type;     /* ES_UINT32 for ids, ES_FLOAT32 for all others */
    int32_t channels;        /* as aov.h lists them */
    const void* data;        /* top row first, channels interleaved; any alignment */
    size_t row_stride_bytes; /* at least width * channels * 4 */
} es_plane;

/* ES_ABI_VERSION of the library's own build; a host refuses a library with another version. Any thread. */
ES_API uint32_t es_abi_version(void);
/* Version of the library, such as "0.1.0"; static storage. Any thread. */
ES_API const char* es_version(void);

/* Opens or resumes a sequence: checks every setting, makes the folder, writes manifest.json. A folder whose manifest
 * has other settings is refused unless `overwrite` is set; the first finished frame then removes those frames. A
 * folder belongs to one open sequence at a time, of this process or any other: a second one is refused. The caller
 * closes *sequence, which is NULL on failure. */
ES_API es_status es_sequence_open(const es_sequence_settings* settings, es_sequence** sequence, es_error* error);
/* Non-zero when frame `index` is already finished and would be kept: the host need not render it. 0 for NULL. */
ES_API int es_sequence_has_frame(const es_sequence* sequence, int64_t index);
/* Frees the sequence; open frames must have been ended or discarded. NULL is allowed. */
ES_API void es_sequence_close(es_sequence* sequence);

/* Starts a frame. The caller ends or discards *frame, which is NULL on failure. */
ES_API es_status es_frame_begin(es_sequence* sequence, const es_frame_settings* settings, es_frame** frame,
                                es_error* error);
/* Fills the next tile, each once: ES_OK, then ES_DONE; ES_FAILED when memory is short, ES_BAD_INPUT for NULL. If the
 * host handed over all other planes whole, and a denoiser's guides too, only tiles of group "reference" are left. */
ES_API es_status es_frame_next_tile(es_frame* frame, es_tile* tile);
/* Hidden layer only, before any other ray of the tile: fills at most pixel_count rays for which the film needs a
 * distance, and returns their number. The host answers with es_tile_put_distances and calls again until the call
 * returns 0. In other sequences it returns 0 at once. */
ES_API uint32_t es_tile_probe_rays(es_frame* frame, const es_tile* tile, es_ray* rays);
/* One distance for each probe ray, in their order: metres from the ray's origin to the nearest surface between t_min
 * and t_max. +inf, a negative number or NaN for a miss. */
ES_API void es_tile_put_distances(es_frame* frame, const es_tile* tile, const float* distances_m);
/* Fills rays through the pixel centres and returns their number: pixel_count. A hidden layer asks only for pixels with
 * a hidden surface, an atlas for pixels of used slots, a tile of group "reference" for none. */
ES_API uint32_t es_tile_geometry_rays(const es_frame* frame, const es_tile* tile, es_ray* rays);
/* Fills the jittered rays of colour pass `sample` (0 to sample_count - 1), for the same pixels, and returns their
 * number; a tile of group "reference" asks for all its pixels. Sample positions: the first two Sobol' dimensions,
 * Owen-scrambled for each pixel. */
ES_API uint32_t es_tile_colour_rays(const es_frame* frame, const es_tile* tile, uint32_t sample, es_ray* rays);
/* One surface for each geometry ray, in their order. A distance that is negative or not finite is a miss. */
ES_API void es_tile_put_surfaces(es_frame* frame, const es_tile* tile, const es_surface* surfaces);
/* Adds one colour pass to the film (box filter): four numbers for each colour ray, in their order. R, G, B are
 * radiance; A is 1 where a surface was hit, else 0. Samples that are not finite are left out of their pixel's mean. To
 * be called once for each pass, in their order. */
ES_API void es_tile_put_radiance(es_frame* frame, const es_tile* tile, const float* rgba);
/* Guides of the same pass, for a sequence that is denoised or keeps group "guides"; others ignore them. Six numbers for
 * each colour ray: albedo and world normal of the first rough surface that the sample met, through mirrors and glass. A
 * lamp and the sky give their radiance, at most 1, as albedo; the sky's normal is 0. Numbers that are not finite count
 * as 0. Hosts put guides for all passes of all tiles, or for none. Tiles of group "reference" do not keep them. */
ES_API void es_tile_put_guides(es_frame* frame, const es_tile* tile, const float* guides);
/* Ids at the first hits of the same pass, for a sequence with group "cryptomatte"; others ignore them. Two numbers for
 * each colour ray: object and material, from 1, or 0 for a miss. The group needs all passes of all tiles. Tiles of
 * group "reference" do not keep them. */
ES_API void es_tile_put_ids(es_frame* frame, const es_tile* tile, const uint32_t* ids);
/* Hands over a whole plane, which replaces the tiles' values of it. Not while tiles are being filled. The frame takes
 * the planes that the sequence writes or accumulates by, and guides where it is denoised. It refuses "raw", "samples",
 * "variance" and group "reference". Distances are 0 or more, or +inf for a miss; radiance may be anything; all else is
 * finite. Where a hidden layer has no surface, tiles can say so; a whole plane of depth cannot. */
ES_API es_status es_frame_put_plane(es_frame* frame, const es_plane* plane, es_error* error);
/* Writes the frame (whole or not at all) and frees it, also on failure. Refuses a frame with unfinished tiles, and
 * reports earlier misuse of the es_tile_* calls. */
ES_API es_status es_frame_end(es_frame* frame, es_error* error);
/* Frees the frame without writing it. NULL is allowed. */
ES_API void es_frame_discard(es_frame* frame);

#ifdef __cplusplus
}
#endif
#endif
