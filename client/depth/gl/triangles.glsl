// The client's triangles by their corners, as scene_geometry.h uploads them.

layout(std430, binding = 2) readonly buffer Positions {
    float positions[];
};
layout(std430, binding = 3) readonly buffer TextureCoordinates {
    vec2 uvs[];
};
layout(std430, binding = 4) readonly buffer Indices {
    uint indices[];
};
