#ifndef EQUISTREAM_EQUISTREAM_H
#define EQUISTREAM_EQUISTREAM_H
/*
 * The C ABI by which any renderer (a host) loads libequistream. The plugin owns the cameras, the film, the AOVs and
 * the export; the host traces rays. Two ways in, which may be mixed within one frame:
 *
 *   rays    loop over es_frame_next_tile; for each tile ask for the geometry rays (one per pixel, through its centre)
 *           and for `sample_count` sets of colour rays (one jittered ray per pixel each), and hand answers back;
 *   planes  hand over whole planes by AOV name with es_frame_put_plane.
 *
 * Conventions: conventions.h. Lengths in metres, angles in radians, colour linear Rec.709, scene-referred.
 * Struct growth: every struct a host fills begins with its own size; fields are only ever appended, and those that an
 * older host does not know of are taken to be 0.
 * Threading: a sequence may be used by one thread at a time; es_frame_next_tile and all es_tile_* calls of one frame
 * may run on any number of threads, each tile on one thread at a time. Misuse of a call that returns nothing (a foreign
 * tile, NULL, too many passes) is reported by es_frame_end.
 * Errors: nothing throws, exits or prints. Calls that can fail take an optional es_error, filled on failure.
 */
#include <equistream/abi_types.h>

#ifdef __cplusplus
extern "C" {
#endif

#define ES_ABI_VERSION 3u

/* ES_ODS is omnidirectional stereo (docs/conventions.md): a sphere whose rays begin at eyes of their own, on a circle
 * of diameter ipd_m around the head. Of a left or a right eye; longitudes and latitudes as of ES_EQUIRECT. No hidden
 * layer, no atlas, no window; frames are not accumulated. */
typedef enum es_camera_kind { ES_EQUIRECT = 0, ES_PERSPECTIVE = 1, ES_ODS = 2 } es_camera_kind;
typedef enum es_axis_lock { ES_LOCK_WORLD = 0, ES_LOCK_PATH = 1 } es_axis_lock;
/* Which surface along each pixel's ray a sequence shows: the first, or the next one behind it that an eye of the head
 * box sees past the first (docs/conventions.md, "Hidden layer"). */
typedef enum es_layer { ES_LAYER_FIRST = 0, ES_LAYER_HIDDEN = 1 } es_layer;

/* What is done about the noise of few samples, before a frame is written. All but off take Intel's Open Image Denoise,
 * which is looked for when the sequence is opened. Dearer is better: docs/results/denoise.md. */
typedef enum es_denoise {
    ES_DENOISE_OFF = 0,
    ES_DENOISE_FAST = 1,
    ES_DENOISE_BALANCED = 2,
    ES_DENOISE_HIGH = 3
} es_denoise;

typedef struct es_sequence_settings {
    size_t struct_size;   /* sizeof(es_sequence_settings) */
    uint32_t abi_version; /* ES_ABI_VERSION */
    uint32_t spp;         /* colour samples per pixel, 1 to 1,048,576 */
    uint64_t seed;
    es_camera_kind camera;
    int32_t width, height;
    double fov_x_rad;                    /* perspective only */
    double longitude_min, longitude_max; /* equirect only; both 0: the full circle */
    double latitude_min, latitude_max;   /* equirect only; both 0: pole to pole */
    es_eye eye;
    es_axis_lock lock;
    double ipd_m;
    double head_radius_m;
    double frames_per_second;
    double exposure;
    const char* output_dir;  /* the sequence's folder, made if missing */
    const char* aovs;        /* groups: "depth,motion,normal,albedo,ids", "all", "none"; others by name (aov.h).
                              * With "reference", tiles of colour passes alone follow all others: few and small, but
                              * with many passes. By them is measured how visibly off the finished picture is */
    const char* scene_name;  /* for the record; UTF-8, at most 255 bytes */
    const char* host_name;   /* renderer, version, build: no other adds to its frames; UTF-8, at most 255 bytes */
    const char* command;     /* for the manifest; may be NULL */
    const char* fingerprint; /* what else decides the pixels (a hash of the scene, say); may be NULL */
    int32_t overwrite;       /* non-zero: finished frames are rendered again; zero: they are kept (resume) */
    int32_t single_part;     /* non-zero: EXR with one part and a plain Z besides */
    /* Names the geometry alone: a client refuses another one's. UTF-8, at most 255 bytes; may be NULL. */
    const char* geometry_fingerprint;
    es_layer layer;
    int32_t tile_side; /* pixels that a tile is wide and high at most, 1 to 32,768; 0: 32 */
    /* Of an atlas of patches (patches.h) around the sphere that all else is of; patch_side 0: the sphere itself. Pixels
     * that a patch is wide and high, slots that the atlas is; where the auxiliary spheres' centres are, three numbers
     * each, from the sphere's and in its axes. An atlas has no motion and is no hidden layer. */
    int32_t patch_side, patch_columns, patch_rows;
    uint32_t patch_offset_count;
    const double* patch_offsets_m;
    /* Plane "colour" is denoised when a frame is ended; group "raw" keeps it as it was. Guides help:
     * es_tile_put_guides, or planes "guide_albedo" and "guide_normal", else "albedo" and "normal". */
    es_denoise denoise;
    uint32_t denoise_threads; /* of the denoiser, where it computes on a CPU; 0: one a processor */
    /* Above 0, at most 1,000: each frame's colour is the mean over the frames before it as well, which exact motion
     * finds again; where anything moved, so many earlier frames count at most. A frame goes on from the one that was
     * ended last if its head_previous is where the head was then, and it says how many frames ago that is. Any other
     * begins anew. Tiles get more samples or fewer, so that they are where they are needed, spp on average. Planes
     * must be finished that such a mean needs, wanted or not: groups depth, motion, normal, ids, specular, virtual.
     * Groups "samples" and "variance" tell how good it is. No hidden layer, no atlas. */
    uint32_t accumulate_frames;
    /* Above 0, at most 32,768: each frame is a window (window.h), part of a whole equirect sphere of so many columns
     * and half as many rows: a multiple of 16, as width and height are, which are the window's. es_frame_settings says
     * where it is. Ranges are 0; no hidden layer, no atlas. Its rays are those of the whole sphere. */
    int64_t window_columns;
    /* Non-zero: tiles of a sphere or a window get samples in proportion to the angle that their pixels span, spp on the
     * equator and one at least. So the noise that an eye sees is everywhere the same, for 0.64 of a sphere's samples.
     * Only where tiles are sampled alike otherwise: not where frames are accumulated. */
    int64_t samples_by_angle;
    /* Above 0, at most 65,536: every frame is rendered in so many parts, each by a program of its own. `part` is this
     * program's, from 1: tiles of it alone are handed out, and es_frame_end keeps their sums in a folder of output_dir.
     * With `part` 0 frames are put together from all parts, which then go; no tile is handed out. These frames have the
     * bytes of frames that were rendered whole. Tiles bring every plane; frames are not accumulated; no atlas, and no
     * window in a base. */
    uint32_t part_count, part;
    /* Of group "cryptomatte": what the objects and materials with the ids 1, 2 and so on are called. UTF-8; NULL, or
     * fewer than there are ids: the others are called after their numbers. `fingerprint` has to cover them. No hidden
     * layer, no atlas, no accumulated frames, no base of a window. Borrowed until the call returns. */
    const char* const* object_names;
    const char* const* material_names;
    uint32_t object_name_count, material_name_count;
} es_sequence_settings;

/* What a slot of an atlas shows: a block of one auxiliary sphere. */
typedef struct es_patch {
    int32_t used; /* zero: nothing; no rays are asked for it */
    uint32_t offset_index, block_x, block_y;
} es_patch;

typedef struct es_sequence es_sequence;
typedef struct es_frame es_frame;

typedef struct es_frame_settings {
    size_t struct_size;
    int64_t index;                          /* 0 to 999,999,999 */
    double time_s;                          /* from -1e10 to 1e10 */
    es_pose head_previous, head, head_next; /* a missing neighbour: repeat `head` (zero camera motion) */
    const es_patch* patches;                /* of an atlas: its slots, row by row; borrowed until the call returns */
    size_t patch_count;
    uint32_t spp;             /* of this frame, where frames are accumulated; 0: the sequence's */
    uint32_t previous_frames; /* how many frames ago head_previous, and positions "previous", are; 0: 1 */
    /* Of a sequence of windows: this one's upper left corner on its sphere, in multiples of 16. x goes round; the
     * window ends at the poles. */
    int32_t window_x, window_y;
    /* Of a whole equirect sphere, the base: a sequence of windows on a denser one, of the same eye and axes. It began
     * the frame of this index last, with the same poses, or keeps it; it ends it before this frame is ended. Pixels of
     * the base that the window covers entirely get the mean of its finished colours. Tiles that it covers entirely have
     * no colour passes, unless frames are accumulated; planes "raw" and guides are not rendered there. NULL: none.
     * es_frame_begin reads that sequence: no other thread may begin a frame of it meanwhile. */
    const es_sequence* window;
} es_frame_settings;

/* A rectangle of pixels to render; of group "reference" it overlaps others. Filled by es_frame_next_tile; treat as
 * read-only. */
typedef struct es_tile {
    uint32_t id;
    int32_t x, y, width, height;
    uint32_t pixel_count;  /* width * height; pixels run row by row, top down. No call asks for more rays than that */
    uint32_t sample_count; /* colour passes; 0 where a window shows the colour */
} es_tile;

typedef struct es_ray {
    float origin[3];
    float t_min;
    float direction[3]; /* unit */
    float t_max;
    uint64_t seed;       /* differs for every (sequence seed, frame, pixel, sample) */
    float footprint_rad; /* angle one pixel spans here, for texture filtering */
    uint32_t pixel;      /* index within the tile */
} es_ray;

/* What a geometry ray saw. For a miss set distance_m to +inf and the rest to 0. */
typedef struct es_surface {
    float distance_m;             /* Euclidean, from the ray's origin */
    float position_previous_m[3]; /* the same surface point at the previous frame, world space */
    float position_next_m[3];     /* and at the next one */
    float normal[3];              /* world, unit, facing the camera */
    float albedo[3];
    uint32_t object_id, material_id, instance_id; /* from 1 */
    /* 1 where over 3/4 of what the surface sends on leaves as a sharp reflection or refraction, else 0 */
    float specular;
    /* Of what is seen sharply in the surface: how far along the ray it appears to lie (virtual_image.h), +inf where it
     * has no end, and where it will appear to lie from the neighbouring frames. 0: the surface itself is seen. */
    float virtual_distance_m;
    float virtual_previous_m[3], virtual_next_m[3];
} es_surface;

typedef enum es_sample_type { ES_FLOAT32 = 0, ES_UINT32 = 1 } es_sample_type;

typedef struct es_plane {
    size_t struct_size;
    const char* name; /* AOV plane name: "colour", "depth", "backward", ... (aov.h) */
    es_sample_type type;
    int32_t channels;
    const void* data;        /* borrowed until the call returns; top row first, samples interleaved */
    size_t row_stride_bytes; /* at least width * channels * 4 */
} es_plane;

/* The version this library was built with; a host refuses another one. */
ES_API uint32_t es_abi_version(void);
/* Such as "0.1.0"; static storage. */
ES_API const char* es_version(void);

/* Opens (or resumes) a sequence: checks every setting, makes the folder, writes manifest.json. A folder whose manifest
 * has other settings is refused unless `overwrite` is set; the first finished frame then removes those frames. A
 * folder belongs to one open sequence at a time, of this process or any other: a second one is refused. The caller
 * closes *sequence. */
ES_API es_status es_sequence_open(const es_sequence_settings* settings, es_sequence** sequence, es_error* error);
/* Non-zero when frame `index` is already finished and would be kept. */
ES_API int es_sequence_has_frame(const es_sequence* sequence, int64_t index);
/* Frees the sequence; open frames must have been ended or discarded. NULL is allowed. */
ES_API void es_sequence_close(es_sequence* sequence);

/* Starts a frame. The caller ends or discards it. */
ES_API es_status es_frame_begin(es_sequence* sequence, const es_frame_settings* settings, es_frame** frame,
                                es_error* error);
/* Hands out each tile once: ES_OK, then ES_DONE. Where all other planes were handed over whole, tiles of group
 * "reference" are left. */
ES_API es_status es_frame_next_tile(es_frame* frame, es_tile* tile);
/* Of a hidden layer, before any other ray of the tile: fills rays of which the film must know how far they go (to the
 * nearest surface between t_min and t_max) and returns how many; to be answered by es_tile_put_distances and asked
 * again until there are none. Other sequences have none. */
ES_API uint32_t es_tile_probe_rays(es_frame* frame, const es_tile* tile, es_ray* rays);
/* As many distances as there were probe rays, each from its ray's origin; +inf (or negative, NaN) for a miss. */
ES_API void es_tile_put_distances(es_frame* frame, const es_tile* tile, const float* distances_m);
/* Fills rays through the pixel centres and returns how many: pixel_count; of a hidden layer those alone that it has, of
 * an atlas those of used slots, of a reference none. */
ES_API uint32_t es_tile_geometry_rays(const es_frame* frame, const es_tile* tile, es_ray* rays);
/* Fills jittered rays of colour pass `sample` (0 .. sample_count - 1), for the same pixels, and returns how many. */
ES_API uint32_t es_tile_colour_rays(const es_frame* frame, const es_tile* tile, uint32_t sample, es_ray* rays);
/* As many answers as there were geometry rays. A distance that is negative or not finite is a miss. */
ES_API void es_tile_put_surfaces(es_frame* frame, const es_tile* tile, const es_surface* surfaces);
/* As many RGBA samples as there were colour rays (A: 1 where a surface was hit), added to the film (box filter).
 * Samples that are not finite are left out of their pixel's mean. */
ES_API void es_tile_put_radiance(es_frame* frame, const es_tile* tile, const float* rgba);
/* Guides of the same pass, for a sequence that is denoised or keeps group "guides"; others ignore them. Six numbers a
 * ray: albedo and world normal of the first rough surface that the sample met, through mirrors and glass; of a lamp or
 * the sky its radiance, at most 1, for an albedo, and of the sky no normal (0). All passes of all tiles, or none; those
 * of group "reference" are not kept. */
ES_API void es_tile_put_guides(es_frame* frame, const es_tile* tile, const float* guides);
/* What the rays of the same pass met first, for a sequence with group "cryptomatte"; others ignore it. Two numbers a
 * ray: object and material, from 1, or 0 for a miss. All passes of all tiles; those of group "reference" are not
 * kept. */
ES_API void es_tile_put_ids(es_frame* frame, const es_tile* tile, const uint32_t* ids);
/* Hands over a whole plane; it takes the place of what tiles say of it. Not while tiles are being filled. */
ES_API es_status es_frame_put_plane(es_frame* frame, const es_plane* plane, es_error* error);
/* Writes the frame (whole or not at all) and frees it, also on failure. Refuses a frame with unfinished tiles. */
ES_API es_status es_frame_end(es_frame* frame, es_error* error);
/* Frees the frame without writing it. NULL is allowed. */
ES_API void es_frame_discard(es_frame* frame);

#ifdef __cplusplus
}
#endif
#endif
