#include "shadow.h"

#include <scenes/embree/embree_rays.h>

#include <cmath>

namespace equistream::embree_host {
namespace {

#if RTC_VERSION_MAJOR >= 4
using QueryContext = RTCRayQueryContext;
#else
using QueryContext = RTCIntersectContext;
#endif

/// What the filter below needs, behind the context that Embree hands it.
struct GlassQuery {
    QueryContext context;  // first: the filter casts back from it
    const Bvh* bvh;
    const ShadingScene* scene;
    Textures::Reader* textures;
    Segment segment;
    glm::vec3 transmittance;
};

/// Lets light through glass: tints it and rejects the hit. Opaque hits stand.
void pass_through_glass(const RTCFilterFunctionNArguments* arguments) {
    if (arguments->valid[0] != -1)
        return;
    auto& query = *reinterpret_cast<GlassQuery*>(arguments->context);
    RTCHit hit;
    hit.geomID = RTCHitN_geomID(arguments->hit, arguments->N, 0);
    hit.primID = RTCHitN_primID(arguments->hit, arguments->N, 0);
    hit.instID[0] = RTCHitN_instID(arguments->hit, arguments->N, 0, 0);
    hit.u = RTCHitN_u(arguments->hit, arguments->N, 0);
    hit.v = RTCHitN_v(arguments->hit, arguments->N, 0);
    const HitId id = query.bvh->resolve(hit);
    const ShadingMaterial& material = query.scene->material(query.scene->material_of(id.instance));
    if (!material.thin_glass)
        return;
    const float distance = RTCRayN_tfar(arguments->ray, arguments->N, 0);
    const ShadingPoint point = query.scene->surface_at(id, query.segment.origin, query.segment.direction, distance);
    const SurfaceParameters parameters = surface_parameters(material, point, 0, glm::vec3(0.5f), *query.textures);
    query.transmittance *=
        straight_transmittance(parameters, std::abs(glm::dot(point.normal, query.segment.direction)));
    arguments->valid[0] = 0;
}

void query_occluded(RTCScene scene, GlassQuery& query, RTCRay& ray) {
#if RTC_VERSION_MAJOR >= 4
    RTCOccludedArguments arguments;
    rtcInitOccludedArguments(&arguments);
    rtcInitRayQueryContext(&query.context);
    arguments.context = &query.context;
    arguments.filter = pass_through_glass;
    arguments.flags = RTC_RAY_QUERY_FLAG_INVOKE_ARGUMENT_FILTER;
    rtcOccluded1(scene, &ray, &arguments);
#else
    rtcInitIntersectContext(&query.context);
    query.context.filter = pass_through_glass;
    rtcOccluded1(scene, &query.context, &ray);
#endif
}

}  // namespace

glm::vec3 transmittance(const Bvh& bvh, const ShadingScene& scene, Textures::Reader& textures, const Segment& segment) {
    RTCRay ray = embree_ray(segment.origin, segment.direction, segment.distance);
    if (!scene.has_thin_glass())
        return glm::vec3(bvh.occluded1(ray) ? 0 : 1);
    GlassQuery query{{}, &bvh, &scene, &textures, segment, glm::vec3(1)};
    query_occluded(bvh.scene(), query, ray);
    return ray.tfar < 0 ? glm::vec3(0) : query.transmittance;
}

}  // namespace equistream::embree_host
