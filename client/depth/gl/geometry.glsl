// The scene's clusters and where their instances are, as DepthPass has them.

struct Item {
    vec4 ball;  // in the mesh's axes
    uint first_index, index_count, instance, masked;
};

layout(std430, binding = 0) readonly buffer Items {
    Item items[];
};
layout(std430, binding = 1) readonly buffer Transforms {
    mat4 world_from_object[];
};
