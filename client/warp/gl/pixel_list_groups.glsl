// How many work groups the list needs; once, where each pixel's counting them would cost all pixels.
layout(local_size_x = 1) in;

#include "pixel_list.glsl"

void main() {
    uint groups = (pixel_count + LIST_GROUP - 1u) / LIST_GROUP;
    pixel_groups[0] = min(groups, MAX_GROUPS);
    pixel_groups[1] = (groups + MAX_GROUPS - 1u) / MAX_GROUPS;
}
