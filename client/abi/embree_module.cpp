/// Embree's module of libequistream_client: rays into the scene's geometry.
#include "module_loading.h"

#include <client/depth/ray_colour.h>
#include <client/depth/ray_depth.h>

namespace equistream {

namespace {

std::unique_ptr<DepthSource> depth(const SceneDescription& scene) {
    return std::make_unique<RayDepth>(scene);
}

std::unique_ptr<GeometryColour> colour(const SceneDescription& scene) {
    auto geometry = std::make_unique<RayColour>(scene);
    geometry->start_loading();
    return geometry;
}

}  // namespace

}  // namespace equistream

extern "C" __attribute__((visibility("default"))) const equistream::ExportedModule<equistream::RayModule>
    equistream_client_module_embree;
const equistream::ExportedModule<equistream::RayModule> equistream_client_module_embree = {
    equistream::code_identity(), {.depth = equistream::depth, .colour = equistream::colour}};
