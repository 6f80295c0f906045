#include <equistream_embree/path_tracer.h>

#include <equistream_embree/directions.h>
#include <equistream_embree/shadow.h>

#include <algorithm>
#include <cassert>
#include <cmath>
#include <limits>

namespace equistream::embree_host {
namespace {

constexpr float infinity = std::numeric_limits<float>::infinity();
/// Straight passes through glass do not count as bounces; this ends paths caught between panes.
constexpr std::uint8_t most_vertices = 64;
/// Russian roulette: after this many scatterings a path goes on with this many times its throughput as probability.
/// Chosen by variance times rays on both real scenes: 1 and 2 give 1 to 10 % less than the usual 2 and 1, and a fifth
/// fewer rays.
constexpr std::uint8_t bounces_before_roulette = 1;
constexpr float roulette_leniency = 2;
/// The widest cone a path is taken for, whatever it scattered off.
constexpr float widest_spread_rad = 0.3f;

glm::vec3 to_vec3(const float (&v)[3]) {
    return {v[0], v[1], v[2]};
}

/// Veach's power heuristic for one sample each.
float power_heuristic(float pdf, float other) {
    const float ratio = other / pdf;
    return 1 / (1 + ratio * ratio);
}

RTCRayHit ray_hit(const glm::vec3& origin, const glm::vec3& direction) {
    RTCRayHit r{};
    r.ray.org_x = origin.x;
    r.ray.org_y = origin.y;
    r.ray.org_z = origin.z;
    r.ray.dir_x = direction.x;
    r.ray.dir_y = direction.y;
    r.ray.dir_z = direction.z;
    r.ray.tfar = infinity;
    r.ray.mask = ~0u;
    r.hit.geomID = RTC_INVALID_GEOMETRY_ID;
    r.hit.instID[0] = RTC_INVALID_GEOMETRY_ID;
    return r;
}

}  // namespace

RayCounts& RayCounts::operator+=(const RayCounts& o) {
    paths += o.paths;
    path_rays += o.path_rays;
    shadow_rays += o.shadow_rays;
    texture_calls += o.texture_calls;
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
        RTCRayHit16 packet{};
        alignas(64) int valid[16] = {};
        for (std::size_t i = 0; i < n; ++i) {
            const es_ray& ray = rays[first + i];
            valid[i] = -1;
            packet.ray.org_x[i] = ray.origin[0];
            packet.ray.org_y[i] = ray.origin[1];
            packet.ray.org_z[i] = ray.origin[2];
            packet.ray.dir_x[i] = ray.direction[0];
            packet.ray.dir_y[i] = ray.direction[1];
            packet.ray.dir_z[i] = ray.direction[2];
            packet.ray.tnear[i] = ray.t_min;
            packet.ray.tfar[i] = ray.t_max;
            packet.ray.mask[i] = ~0u;
            packet.hit.geomID[i] = RTC_INVALID_GEOMETRY_ID;
            packet.hit.instID[0][i] = RTC_INVALID_GEOMETRY_ID;
        }
        scene_.bvh.intersect16(valid, packet);
        for (std::size_t i = 0; i < n; ++i) {
            RTCHit hit;
            hit.geomID = packet.hit.geomID[i];
            hit.primID = packet.hit.primID[i];
            hit.instID[0] = packet.hit.instID[0][i];
            hit.u = packet.hit.u[i];
            hit.v = packet.hit.v[i];
            hits[first + i] = {scene_.bvh.resolve(hit), packet.ray.tfar[i]};
        }
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
                            std::uint32_t sample, std::span<float> rgba) {
    assert(pixel_seeds.size() == rays.size() && rgba.size() == rays.size() * 4);
    counts_.film_s += clock_.lap();
    start_paths(rays, pixel_seeds, sample);
    counts_.shading_s += clock_.lap();
    trace_coherent(rays, hits_);
    counts_.camera_rays_s += clock_.lap();
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
        rgba[4 * i] = radiance.x;
        rgba[4 * i + 1] = radiance.y;
        rgba[4 * i + 2] = radiance.z;
        rgba[4 * i + 3] = paths_[i].covered ? 1.0f : 0.0f;
    }
    counts_.shading_s += clock_.lap();
}

void Worker::trace_paths() {
    hits_.resize(active_.size());
    counts_.path_rays += active_.size();
    for (std::size_t i = 0; i < active_.size(); ++i) {
        const Path& path = paths_[active_[i]];
        RTCRayHit r = ray_hit(path.origin, path.direction);
        scene_.bvh.intersect1(r);
        hits_[i] = {scene_.bvh.resolve(r.hit), r.ray.tfar};
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
        paths_[ray.path].radiance += ray.contribution * transmittance(scene_.bvh, scene_.shading, textures_, ray.origin,
                                                                      ray.direction, ray.distance);
    shadow_rays_.clear();
}

void Worker::escape(Path& path) const {
    path.radiance += path.throughput * scene_.lights.sky;
    const auto& sun = scene_.lights.sun;
    if (!sun || !sun->contains(path.direction))
        return;
    float weight = 1;
    if (path.next_event_done)
        weight = power_heuristic(path.scatter_pdf, sun->pdf);
    else if (path.after_rough && path.scatter_pdf == 0)
        weight = 0;  // a caustic, dropped
    path.radiance += weight * path.throughput * sun->radiance;
}

void Worker::add_emission(Path& path, const ShadingMaterial& material, const ShadingPoint& point, float distance,
                          const glm::vec3& jitter) {
    const float footprint = path.cone.width_m;
    const glm::vec3 emitted = emitted_radiance(material, point, footprint, jitter, textures_);
    if (is_black(emitted))
        return;
    float weight = 1;
    if (path.next_event_done) {
        const float cosine = std::abs(glm::dot(point.geometric_normal, path.direction));
        const float travelled = path.scatter_distance + distance;
        const float light_pdf = material.emission_pdf_area * travelled * travelled / std::max(cosine, 1e-6f);
        weight = power_heuristic(path.scatter_pdf, light_pdf);
    }
    path.radiance += weight * path.throughput * emitted;
}

bool Worker::shade(std::uint32_t index, const Hit& hit) {
    Path& path = paths_[index];
    path.covered = true;
    const ShadingPoint point = scene_.shading.surface_at(hit.id, path.origin, path.direction, hit.distance);
    const ShadingMaterial& material = scene_.shading.material(point.material);
    path.cone.width_m += path.cone.spread_rad * hit.distance;
    const glm::vec3 jitter{path.sampler.next_hashed(), path.sampler.next_hashed(), path.sampler.next_hashed()};
    if (material.emits)
        add_emission(path, material, point, hit.distance, jitter);
    path.scatter_distance += hit.distance;
    // After the last bounce a path still goes straight through glass to a light, as shadow rays do.
    const bool spent = path.bounces >= scene_.options.max_bounces;
    if ((spent && !material.thin_glass) || path.vertices >= most_vertices)
        return false;

    const SurfaceParameters parameters = surface_parameters(material, point, path.cone.width_m, jitter, textures_);
    const float alpha_floor = path.after_rough && scene_.options.widen_lobes ? path.cone.spread_rad : 0;
    const Bsdf bsdf(parameters, glm::dot(point.normal, -path.direction), alpha_floor);
    const ShadingFrame frame(point.normal);
    if (scene_.options.next_event && !spent && bsdf.has_rough_lobe())
        sample_lights(index, point, bsdf, frame);
    return scatter(path, point, bsdf, frame);
}

void Worker::sample_lights(std::uint32_t index, const ShadingPoint& point, const Bsdf& bsdf,
                           const ShadingFrame& frame) {
    if (scene_.lights.sun)
        sample_sun(index, point, bsdf, frame);
    if (!scene_.lights.emitters.empty())
        sample_emitter(index, point, bsdf, frame);
}

void Worker::sample_sun(std::uint32_t index, const ShadingPoint& point, const Bsdf& bsdf, const ShadingFrame& frame) {
    const SunLight& sun = *scene_.lights.sun;
    if (glm::dot(sun.towards, point.geometric_normal) <= 0)
        return;
    Path& path = paths_[index];
    const glm::vec2 u = path.sampler.pair(path.vertices, Sampler::Use::sun);
    const glm::vec3 direction = sun.frame.to_world(sample_cone(u, sun.one_minus_cos));
    if (glm::dot(direction, point.geometric_normal) <= 0)
        return;
    const BsdfValue scattered = bsdf.evaluate(frame.to_local(-path.direction), frame.to_local(direction));
    const glm::vec3 contribution =
        path.throughput * scattered.value * sun.radiance * (power_heuristic(sun.pdf, scattered.pdf) / sun.pdf);
    if (largest(contribution) > 0)
        shadow_rays_.push_back(
            {offset_origin(point.position, point.geometric_normal), direction, contribution, infinity, index});
}

void Worker::sample_emitter(std::uint32_t index, const ShadingPoint& point, const Bsdf& bsdf,
                            const ShadingFrame& frame) {
    Path& path = paths_[index];
    const float choice = path.sampler.pair(path.vertices, Sampler::Use::choices).y;
    const glm::vec2 u = path.sampler.pair(path.vertices, Sampler::Use::emitter);
    const EmitterSample emitter = scene_.lights.emitters.sample(choice, u);
    const ShadingMaterial& material = scene_.shading.material(emitter.material);
    const glm::vec3 origin = offset_origin(point.position, point.geometric_normal);
    const glm::vec3 across = emitter.position - origin;
    const float distance2 = glm::dot(across, across);
    if (!(distance2 > 0))
        return;
    const float distance = std::sqrt(distance2);
    const glm::vec3 direction = across / distance;
    const float cosine = -glm::dot(direction, emitter.normal);
    if (glm::dot(direction, point.geometric_normal) <= 0 || (cosine <= 0 && !material.double_sided) ||
        std::abs(cosine) < 1e-6f)
        return;
    const float pdf = material.emission_pdf_area * distance2 / std::abs(cosine);
    const BsdfValue scattered = bsdf.evaluate(frame.to_local(-path.direction), frame.to_local(direction));
    if (is_black(scattered.value))
        return;
    glm::vec3 emitted = material.emission;
    if (material.emission_texture != no_index)
        emitted *= textures_.lookup(material.emission_texture, {emitter.uv, 0, glm::vec3(0.5f)});
    const glm::vec3 contribution =
        path.throughput * scattered.value * emitted * (power_heuristic(pdf, scattered.pdf) / pdf);
    if (largest(contribution) > 0)
        shadow_rays_.push_back({origin, direction, contribution, distance * 0.9999f, index});
}

bool Worker::scatter(Path& path, const ShadingPoint& point, const Bsdf& bsdf, const ShadingFrame& frame) {
    const float lobe = path.sampler.pair(path.vertices, Sampler::Use::choices).x;
    const glm::vec2 u = path.sampler.pair(path.vertices, Sampler::Use::scattering);
    const BsdfSample s = bsdf.sample(frame.to_local(-path.direction), lobe, u);
    ++path.vertices;
    if (s.kind == BsdfSample::Kind::none || !(largest(s.weight) > 0))
        return false;
    path.throughput *= s.weight;
    if (s.kind == BsdfSample::Kind::straight) {
        path.origin = offset_origin(point.position, -point.geometric_normal);
        return true;
    }
    if (path.bounces >= scene_.options.max_bounces)
        return false;
    path.direction = glm::normalize(frame.to_world(s.direction));
    if (glm::dot(path.direction, point.geometric_normal) <= 0)
        return false;
    path.origin = offset_origin(point.position, point.geometric_normal);
    path.scatter_distance = 0;
    const bool rough = s.kind == BsdfSample::Kind::rough;
    path.next_event_done = rough && scene_.options.next_event;
    path.scatter_pdf = rough ? s.pdf : 0;
    if (rough) {
        path.after_rough = true;
        path.cone.spread_rad = std::max(path.cone.spread_rad, std::min(widest_spread_rad, 0.25f / std::sqrt(s.pdf)));
    }
    if (++path.bounces <= bounces_before_roulette)
        return true;
    const float survival = std::min(1.0f, roulette_leniency * largest(path.throughput));
    if (path.sampler.next_hashed() >= survival)
        return false;
    path.throughput /= survival;
    return true;
}

}  // namespace equistream::embree_host
