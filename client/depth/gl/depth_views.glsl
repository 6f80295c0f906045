// Views that depth is drawn of, a layer each, as std140 has DepthPass::ViewBlock.

struct DepthView {
    mat4 view_from_world;
    vec4 planes[4];  // sides of the pyramid that is seen, in the view's axes, pointing inwards
    vec4 scale;      // focal length over half the width and over half the height; y runs down
    vec4 size;       // columns, rows
};

layout(std140, binding = 0) uniform DepthViews {
    DepthView views[MAX_VIEWS];
};
