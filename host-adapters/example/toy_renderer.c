/* A toy renderer made a host of equistream: a moving ball above a checkered floor under a sun and a blue sky.
 *     cc toy_renderer.c -lequistream -lm -o toy_renderer && ./toy_renderer OUT_DIR
 * Lengths are metres, +Y is up, colours are linear. Everything but trace() and shade() is what any host has to do. */
#include <equistream/equistream.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>

enum { width = 256, height = 128, frames = 2, spp = 16 };
static const float floor_y = -1, ball_radius = 0.8f, to_sun[3] = {0.48f, 0.8f, 0.36f};

static float ball_x(int frame) { return 0.4f * (float)frame; } /* it rolls to the right, at z = -3 */

/* The nearest surface along a ray at a frame: where it is, where it was and where it will be. */
static es_surface trace(const es_ray* ray, int frame) {
    es_surface s = {.distance_m = INFINITY};
    const float *o = ray->origin, *d = ray->direction;
    const float centre[3] = {ball_x(frame), 0, -3};
    float b = 0, c = -ball_radius * ball_radius;
    for (int i = 0; i < 3; i++) b += (o[i] - centre[i]) * d[i], c += (o[i] - centre[i]) * (o[i] - centre[i]);
    const float t_ball = -b - sqrtf(b * b - c), t_floor = (floor_y - o[1]) / d[1]; /* NaN where the ball is missed */
    const int ball = t_ball > ray->t_min,
              on_floor = t_floor > ray->t_min && t_floor < 50 && !(ball && t_ball < t_floor);
    if (!ball && !on_floor) return s;
    s.distance_m = on_floor ? t_floor : t_ball;
    for (int i = 0; i < 3; i++) {
        const float p = o[i] + s.distance_m * d[i];
        s.position_previous_m[i] = s.position_next_m[i] = p;
        s.normal[i] = on_floor ? (float)(i == 1) : (p - centre[i]) / ball_radius;
    }
    if (!on_floor) { /* the ball moves, so its points do */
        s.position_previous_m[0] += ball_x(frame - 1) - ball_x(frame);
        s.position_next_m[0] += ball_x(frame + 1) - ball_x(frame);
    }
    const int dark = on_floor && ((int)floorf(s.position_next_m[0]) + (int)floorf(s.position_next_m[2])) % 2;
    for (int i = 0; i < 3; i++) s.albedo[i] = dark ? 0.1f : on_floor ? 0.7f : (float[]){0.8f, 0.3f, 0.1f}[i];
    s.object_id = s.material_id = s.instance_id = on_floor ? 1 : 2;
    return s;
}

/* Colour along a ray: Lambert's law under a sun, some light from everywhere, and a sky that brightens upwards. */
static void shade(const es_ray* ray, int frame, float rgba[4]) {
    const es_surface s = trace(ray, frame);
    const int hit = s.distance_m < INFINITY;
    const float sun = s.normal[0] * to_sun[0] + s.normal[1] * to_sun[1] + s.normal[2] * to_sun[2];
    for (int i = 0; i < 3; i++)
        rgba[i] = hit ? s.albedo[i] * (0.3f + 2 * fmaxf(sun, 0)) : 0.4f + 0.2f * ray->direction[1];
    rgba[3] = (float)hit; /* 1 where a surface was hit */
}

static es_pose head_at(int frame) { return (es_pose){{0, 0.2, -0.1 * frame}, {1, 0, 0, 0}}; } /* walking forward */

static void check(es_status status, const es_error* error) {
    if (status == ES_OK) return;
    fprintf(stderr, "toy_renderer: %s\n", error->text);
    exit(status == ES_BAD_INPUT ? 2 : 1);
}

int main(int argc, char** argv) {
    if (argc != 2) return fprintf(stderr, "usage: toy_renderer OUT_DIR\n"), 2;
    static es_ray rays[width * height];
    static es_surface surfaces[width * height];
    static float colours[width * height * 4];
    es_error error;
    es_sequence* sequence;
    const es_sequence_settings settings = {.struct_size = sizeof settings,
                                           .abi_version = ES_ABI_VERSION,
                                           .spp = spp,
                                           .seed = 1,
                                           .camera = ES_EQUIRECT,
                                           .width = width,
                                           .height = height,
                                           .ipd_m = 0.063,
                                           .frames_per_second = 30,
                                           .exposure = 1,
                                           .output_dir = argv[1],
                                           .aovs = "all",
                                           .scene_name = "toy",
                                           .host_name = "toy_renderer 1"};
    check(es_sequence_open(&settings, &sequence, &error), &error);
    for (int f = 0; f < frames; f++) {
        if (es_sequence_has_frame(sequence, f)) continue; /* finished by an earlier run */
        const es_frame_settings when = {.struct_size = sizeof when,
                                        .index = f,
                                        .time_s = f / 30.0,
                                        .head_previous = head_at(f - 1),
                                        .head = head_at(f),
                                        .head_next = head_at(f + 1)};
        es_frame* frame;
        es_tile tile;
        check(es_frame_begin(sequence, &when, &frame, &error), &error);
        while (es_frame_next_tile(frame, &tile) == ES_OK) { /* this loop may run on any number of threads */
            es_tile_geometry_rays(frame, &tile, rays);
            for (uint32_t i = 0; i < tile.pixel_count; i++) surfaces[i] = trace(&rays[i], f);
            es_tile_put_surfaces(frame, &tile, surfaces);
            for (uint32_t pass = 0; pass < tile.sample_count; pass++) {
                es_tile_colour_rays(frame, &tile, pass, rays);
                for (uint32_t i = 0; i < tile.pixel_count; i++) shade(&rays[i], f, colours + 4 * i);
                es_tile_put_radiance(frame, &tile, colours);
            }
        }
        check(es_frame_end(frame, &error), &error);
    }
    es_sequence_close(sequence);
    return 0;
}
