// What spreading knows of every pixel in or beside tiles with gaps, and of each eye the pixels that may be next and those
// of the layer that was filled last; numbered row by row.
const uint OPEN = 0x80000000u;  // and, in the lower bits, the last layer for which it was a candidate

layout(std430, binding = 2) coherent buffer SpreadStates {
    uint states[];  // the layer that filled a pixel, 0: it was filled before; eye after eye
};
layout(std430, binding = 3) coherent buffer SpreadLists {
    uint candidate_counts[MOST_EYES];
    uint entries[];  // of each eye so many as it has pixels for candidates, then as many for a layer
};
