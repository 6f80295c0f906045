#ifndef TOY_RENDERER_H
#define TOY_RENDERER_H
/* A toy renderer: a ball that rolls over a checkered floor, under a sun and a blue sky. Metres, +Y up. */

typedef struct toy_hit {
    int object;     /* 0: the sky, 1: the floor, 2: the ball */
    float distance; /* INFINITY for the sky */
    float position[3], normal[3], albedo[3];
} toy_hit;

/* What is nearest along a ray (beyond t_min) at a frame. */
toy_hit toy_trace(const float origin[3], const float direction[3], float t_min, int frame);
/* The light that comes from there, linear. */
void toy_shade(const toy_hit* hit, const float direction[3], float rgb[3]);
/* How far along X an object moves from one frame to another. */
float toy_shift(int object, int from_frame, int to_frame);

#endif
