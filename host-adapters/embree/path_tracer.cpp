#include "path_tracer.h"

#include <scenes/embree/embree_rays.h>

#include <algorithm>
#include <cassert>
#include <cmath>

namespace equistream::embree_host {
RayCounts& RayCounts::operator+=(const RayCounts& o) {
    paths += o.paths;
    path_rays += o.path_rays;
    shadow_rays += o.shadow_rays;
    texture_calls += o.texture_calls;
    not_finite += o.not_finite;
    camera_rays_s += o.camera_rays_s;
    path_rays_s += o.path_rays_s;
    shadow_rays_s += o.shadow_rays_s;
    shading_s += o.shading_s;
    film_s += o.film_s;
    return *this;
}

Worker::Worker(const TracedScene& scene) : scene_(scene), textures_(scene.textures) {
    trace_thread_init();
}

RayCounts Worker::counts() const {
    RayCounts c = counts_;
    c.texture_calls = textures_.calls();
    return c;
}

void Worker::trace_coherent(std::span<const es_ray> rays, std::vector<Hit>& hits) {
    hits.resize(rays.size());
    counts_.path_rays += rays.size();
    for (std::size_t first = 0; first < rays.size(); first += 16) {
        const std::size_t n = std::min<std::size_t>(16, rays.size() - first);
        RayPacket packet;
        for (std::size_t i = 0; i < n; ++i) {
            const es_ray& ray = rays[first + i];
            packet.start(i, to_vec3(ray.origin), to_vec3(ray.direction), ray.t_min, ray.t_max);
        }
        scene_.bvh.intersect16(packet.valid.data(), packet.rays);
        for (std::size_t i = 0; i < n; ++i)
            hits[first + i] = {scene_.bvh.resolve(packet.hit(i)), packet.distance(i)};
    }
}

void Worker::start_paths(std::span<const es_ray> rays, std::span<const std::uint64_t> pixel_seeds,
                         std::uint32_t sample) {
    paths_.resize(rays.size());
    active_.resize(rays.size());
    for (std::uint32_t i = 0; i < rays.size(); ++i) {
        paths_[i] = Path{};
        paths_[i].origin = to_vec3(rays[i].origin);
        paths_[i].direction = to_vec3(rays[i].direction);
        paths_[i].sampler = Sampler(pixel_seeds[i], sample);
        paths_[i].cone.spread_rad = rays[i].footprint_rad;
        active_[i] = i;
    }
    counts_.paths += rays.size();
}

void Worker::trace_radiance(std::span<const es_ray> rays, std::span<const std::uint64_t> pixel_seeds,
                            std::uint32_t sample, std::span<float> rgba, std::span<float> guides,
                            std::span<std::uint32_t> ids) {
    assert(pixel_seeds.size() == rays.size() && rgba.size() == rays.size() * 4);
    assert(guides.empty() || guides.size() == rays.size() * 6);
    counts_.film_s += clock_.lap();
    start_paths(rays, pixel_seeds, sample);
    counts_.shading_s += clock_.lap();
    trace_coherent(rays, hits_);
    counts_.camera_rays_s += clock_.lap();
    for (std::size_t i = 0; 2 * i < ids.size(); ++i) {
        const std::uint32_t instance = hits_[i].id.instance;
        const bool hit = instance != no_index;
        ids[2 * i] = hit ? scene_.shading.model().instances[instance].object + 1 : 0;
        ids[2 * i + 1] = hit ? scene_.shading.material_of(instance) + 1 : 0;
    }
    while (!active_.empty()) {
        shade_paths();
        counts_.shading_s += clock_.lap();
        trace_shadow_rays();
        counts_.shadow_rays_s += clock_.lap();
        trace_paths();
        counts_.path_rays_s += clock_.lap();
    }
    for (std::size_t i = 0; i < rays.size(); ++i) {
        const glm::vec3& radiance = paths_[i].radiance;
        counts_.not_finite += !std::isfinite(radiance.x) || !std::isfinite(radiance.y) || !std::isfinite(radiance.z);
        rgba[4 * i] = radiance.x;
        rgba[4 * i + 1] = radiance.y;
        rgba[4 * i + 2] = radiance.z;
        rgba[4 * i + 3] = paths_[i].covered ? 1.0f : 0.0f;
    }
    for (std::size_t i = 0; 6 * i < guides.size(); ++i)
        for (int c = 0; c < 3; ++c) {
            guides[6 * i + static_cast<std::size_t>(c)] = paths_[i].guide_albedo[c];
            guides[6 * i + 3 + static_cast<std::size_t>(c)] = paths_[i].guide_normal[c];
        }
    counts_.shading_s += clock_.lap();
}

Worker::Hit Worker::trace(const glm::vec3& origin, const glm::vec3& direction) {
    ++counts_.path_rays;
    RTCRayHit r = embree_ray_hit(origin, direction);
    scene_.bvh.intersect1(r);
    return {scene_.bvh.resolve(r.hit), r.ray.tfar};
}

void Worker::trace_paths() {
    hits_.resize(active_.size());
    for (std::size_t i = 0; i < active_.size(); ++i) {
        const Path& path = paths_[active_[i]];
        hits_[i] = trace(path.origin, path.direction);
        if (hits_[i].id.instance != no_index)
            scene_.shading.prefetch(hits_[i].id);
    }
}

void Worker::shade_paths() {
    std::size_t kept = 0;
    for (std::size_t i = 0; i < active_.size(); ++i) {
        const std::uint32_t index = active_[i];
        if (hits_[i].id.instance == no_index)
            escape(paths_[index]);
        else if (shade(index, hits_[i]))
            active_[kept++] = index;
    }
    active_.resize(kept);
}

void Worker::trace_shadow_rays() {
    counts_.shadow_rays += shadow_rays_.size();
    for (const ShadowRay& ray : shadow_rays_)
        paths_[ray.path].radiance +=
            ray.contribution * transmittance(scene_.bvh, scene_.shading, textures_, ray.segment);
    shadow_rays_.clear();
}

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
