/* The toy renderer made a host of equistream. Any renderer takes the same four steps: open a sequence, begin a frame,
 * answer its tiles of rays, end the frame. It leaves a folder of EXR frames with depth, motion, normals and ids.
 *     cc toy_host.c toy_renderer.c $(pkg-config --cflags --libs equistream) -lm -o toy_host && ./toy_host OUT_DIR */
#include "toy_renderer.h"

#include <equistream/equistream.h>

#include <stdio.h>
#include <stdlib.h>

enum { width = 256, height = 128, frames = 2, spp = 16 };
static es_ray rays[width * height]; /* no tile is larger than the frame */
static es_surface surfaces[width * height];
static float rgba[width * height][4];

static void check(es_status status, const es_error* error) {
    if (status == ES_OK) return;
    fprintf(stderr, "toy_host: %s\n", error->text);
    exit(status == ES_BAD_INPUT ? 2 : 1);
}

static toy_hit trace(const es_ray* ray, int frame) { return toy_trace(ray->origin, ray->direction, ray->t_min, frame); }

/* What one point of a surface is to equistream: where it is, where it was and will be, and what it is. */
static es_surface surface_of(toy_hit hit, int frame) {
    const uint32_t id = (uint32_t)hit.object;
    es_surface s = {.distance_m = hit.distance, .object_id = id, .material_id = id, .instance_id = id};
    for (int i = 0; i < 3; i++) {
        s.normal[i] = hit.normal[i], s.albedo[i] = hit.albedo[i];
        s.position_previous_m[i] = s.position_next_m[i] = hit.position[i];
    }
    s.position_previous_m[0] += toy_shift(hit.object, frame, frame - 1);
    s.position_next_m[0] += toy_shift(hit.object, frame, frame + 1);
    return s;
}

static void render(es_frame* frame, int f) {
    es_tile tile; /* any number of threads may take tiles, each with buffers of its own */
    es_status status;
    while ((status = es_frame_next_tile(frame, &tile)) == ES_OK) {
        const uint32_t asked = es_tile_geometry_rays(frame, &tile, rays); /* one through the centre of each pixel */
        for (uint32_t i = 0; i < asked; i++) surfaces[i] = surface_of(trace(&rays[i], f), f);
        es_tile_put_surfaces(frame, &tile, surfaces);
        for (uint32_t sample = 0; sample < tile.sample_count; sample++) {
            es_tile_colour_rays(frame, &tile, sample, rays); /* one somewhere in each pixel */
            for (uint32_t i = 0; i < tile.pixel_count; i++) {
                const toy_hit hit = trace(&rays[i], f);
                toy_shade(&hit, rays[i].direction, rgba[i]);
                rgba[i][3] = hit.object != 0; /* alpha: a surface was hit */
            }
            es_tile_put_radiance(frame, &tile, rgba[0]);
        }
    }
    const es_error error = {"no memory for the next tile"};
    check(status == ES_DONE ? ES_OK : status, &error);
}

static es_pose head_at(int frame) { return (es_pose){{0, 0.2, -0.1 * frame}, {1, 0, 0, 0}}; } /* walking forward */

int main(int argc, char** argv) {
    if (argc != 2) return fprintf(stderr, "usage: toy_host OUT_DIR\n"), 2;
    const es_sequence_settings settings = {sizeof settings,     ES_ABI_VERSION,           spp,
                                           .width = width,      .height = height,         .camera = ES_EQUIRECT,
                                           .seed = 1,           .ipd_m = 0.063,           .frames_per_second = 30,
                                           .exposure = 1,       .output_dir = argv[1],    .aovs = "all",
                                           .scene_name = "toy", .host_name = "toy_host 1"};
    es_error error;
    es_sequence* sequence;
    check(es_sequence_open(&settings, &sequence, &error), &error);
    for (int f = 0; f < frames; f++) {
        if (es_sequence_has_frame(sequence, f)) continue; /* finished by an earlier run */
        const es_frame_settings now = {.struct_size = sizeof now,
                                       .index = f,
                                       .time_s = f / 30.0,
                                       .head_previous = head_at(f - 1),
                                       .head = head_at(f),
                                       .head_next = head_at(f + 1)};
        es_frame* frame;
        check(es_frame_begin(sequence, &now, &frame, &error), &error);
        render(frame, f);
        check(es_frame_end(frame, &error), &error);
    }
    es_sequence_close(sequence);
}
