/* What both eyes see of a stream's first frame, as PNG files, while the head turns by a degree a picture.
 *     cc write_pngs.c $(pkg-config --cflags --libs equistream-client libpng) -lm -o write_pngs
 *     ./write_pngs STREAM OUT_DIR PICTURES */
#include <equistream/client.h>

#include <math.h>
#include <png.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

enum { width = 640, height = 480 };
static unsigned char pixels[2][height][width][4];

static void check(es_status status, const es_error* error) {
    if (status == ES_OK) return;
    fprintf(stderr, "write_pngs: %s\n", error->text);
    exit(status == ES_BAD_INPUT ? 2 : 1);
}

static void write_png(const char* folder, const char* eye, int frame, const es_eye_image* image) {
    char name[4096];
    snprintf(name, sizeof name, "%s/%s.%04d.png", folder, eye, frame);
    png_image png = {.version = PNG_IMAGE_VERSION,
                     .width = (png_uint_32)image->width,
                     .height = (png_uint_32)image->height,
                     .format = PNG_FORMAT_RGBA};
    if (png_image_write_to_file(&png, name, 0, image->pixels, width * 4, NULL)) return;
    fprintf(stderr, "write_pngs: %s: %s\n", name, png.message);
    exit(1);
}

int main(int argc, char** argv) {
    if (argc != 4) return fprintf(stderr, "usage: write_pngs STREAM OUT_DIR PICTURES\n"), 2;
    const es_client_settings settings = {
        .struct_size = sizeof settings, .abi_version = ES_CLIENT_ABI_VERSION, .source = argv[1], .paused = 1};
    es_error error;
    es_client* client;
    check(es_client_open(&settings, &client, &error), &error);
    es_client_source source = {.struct_size = sizeof source};
    check(es_client_get_source(client, &source, &error), &error);

    es_client_request request = {
        .struct_size = sizeof request, .head = source.first_head, .width = width, .height = height};
    check(es_client_set_eyes(&request, 1.5708, source.ipd_m, &error), &error);
    for (int frame = 0; frame < atoi(argv[3]); frame++) {
        request.display_s = es_client_now_s(client);
        const double half_turn = 0.5 * frame * 3.14159265358979 / 180; /* about the head's own up */
        const double c = cos(half_turn), s = sin(half_turn), *q = source.first_head.orientation_wxyz;
        const double turned[4] = {q[0] * c - q[2] * s, q[1] * c - q[3] * s, q[0] * s + q[2] * c, q[1] * s + q[3] * c};
        memcpy(request.head.orientation_wxyz, turned, sizeof turned);
        es_eye_image eyes[2] = {{.struct_size = sizeof eyes[0], .pixels = pixels[0]},
                                {.struct_size = sizeof eyes[1], .pixels = pixels[1]}};
        check(es_client_render(client, &request, eyes, NULL, &error), &error);
        write_png(argv[2], "left", frame, &eyes[0]);
        write_png(argv[2], "right", frame, &eyes[1]);
    }
    es_client_close(client);
    return 0;
}
