// How many work groups the list needs; once, where each pixel's counting them would cost all pixels.
layout(local_size_x = 1) in;

#include "look_up_list.glsl"

void main() {
    pixel_groups[0] = (pixel_count + LIST_GROUP - 1u) / LIST_GROUP;
}
