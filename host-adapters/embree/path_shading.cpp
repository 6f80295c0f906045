// Worker, where its paths meet something: emission, light samples, the next direction.
#include "directions.h"
#include "path_tracer.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace equistream::embree_host {
namespace {

constexpr float infinity = std::numeric_limits<float>::infinity();
/// Straight passes through glass do not count as bounces; this ends paths caught between panes.
constexpr int max_straight_passes = 64;
/// Russian roulette: after this many scatterings a path goes on with this many times its throughput as probability.
/// Chosen by variance times rays on both real scenes: 1 and 2 give 1 to 10 % less than the usual 2 and 1, and a fifth
/// fewer rays.
constexpr std::uint8_t bounces_before_roulette = 1;
constexpr float roulette_leniency = 2;
/// The widest cone a path is taken for, whatever it scattered off.
constexpr float widest_spread_rad = 0.3f;

/// Veach's power heuristic for one sample each.
float power_heuristic(float pdf, float other) {
    const float ratio = other / pdf;
    return 1 / (1 + ratio * ratio);
}

}  // namespace

/// Of the samples of the sky, how many choose by its image rather than by openings.
float Worker::share_of_image(const OpeningList& openings) const {
    const auto& image = scene_.lights.sky_image;
    return !image || image->is_black() ? 0 : openings.empty() ? 1 : 0.5f;
}

/// With which sample_sky chooses a direction; `by_openings`: with which these do.
float Worker::sky_pdf(const OpeningList& openings, float by_openings, const glm::vec3& direction) const {
    const float by_image = share_of_image(openings);
    const float image_pdf = by_image > 0 ? by_image * scene_.lights.sky_image->pdf(direction) : 0;
    return image_pdf + (1 - by_image) * by_openings;
}

glm::vec3 Worker::sky_radiance(Path& path) const {
    const auto& image = scene_.lights.sky_image;
    if (path.scatter_pdf > 0) {  // off something rough
        float sampled = 0;
        if (path.next_event_done)
            sampled = sky_pdf(path.openings, path.openings.pdf(path.scattered_at, path.direction), path.direction);
        return power_heuristic(path.scatter_pdf, sampled) * scene_.lights.sampled_sky(path.direction);
    }
    if (!image)
        return scene_.lights.sky;
    const glm::vec3 jitter{path.sampler.next_hashed(), path.sampler.next_hashed(), path.sampler.next_hashed()};
    return scene_.lights.sky + image->filtered(path.direction, path.cone.spread_rad, jitter);
}

/// The first call of a path counts: what stands before it was sharp, and tints what is seen in it.
void Worker::guide(Path& path, const glm::vec3& albedo, const glm::vec3& normal) {
    if (path.guided)
        return;
    path.guided = true;
    path.guide_albedo = glm::min(path.throughput * albedo, glm::vec3(1));
    path.guide_normal = normal;
}

void Worker::escape(Path& path) const {
    const glm::vec3 sky = sky_radiance(path);
    guide(path, sky, {});
    path.radiance += path.throughput * sky;
    const auto& sun = scene_.lights.sun;
    if (!sun || !sun->contains(path.direction))
        return;
    float weight = 1;
    if (path.next_event_done)
        weight = power_heuristic(path.scatter_pdf, sun->pdf);
    else if (path.after_rough && path.scatter_pdf == 0 && !scene_.options.unbiased)
        weight = 0;  // a caustic, dropped
    path.radiance += weight * path.throughput * sun->radiance;
}

void Worker::add_emission(Path& path, const ShadingMaterial& material, const ShadingPoint& point, float distance,
                          const glm::vec3& jitter) {
    const float footprint = path.cone.width_m;
    const glm::vec3 emitted = emitted_radiance(material, point, footprint, jitter, textures_);
    if (is_black(emitted))
        return;
    guide(path, emitted, point.normal);
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
    if ((spent && !material.thin_glass) || path.vertices - path.bounces >= max_straight_passes)
        return false;

    const SurfaceParameters parameters = surface_parameters(material, point, path.cone.width_m, jitter, textures_);
    const float alpha_floor = path.after_rough && !scene_.options.unbiased ? path.cone.spread_rad : 0;
    const Bsdf bsdf(parameters, glm::dot(point.normal, -path.direction), alpha_floor);
    const ShadingFrame frame(point.normal);
    lit_by_ = {};
    if (scene_.options.next_event && !spent && bsdf.has_rough_lobe())
        sample_lights(index, point, bsdf, frame);
    return scatter(path, point, bsdf, frame, parameters.base_colour);
}

void Worker::sample_lights(std::uint32_t index, const ShadingPoint& point, const Bsdf& bsdf,
                           const ShadingFrame& frame) {
    if (scene_.lights.sun)
        sample_sun(index, point, bsdf, frame);
    if (!scene_.lights.emitters.empty())
        sample_emitter(index, point, bsdf, frame);
    sample_sky(index, point, bsdf, frame);
}

void Worker::sample_sun(std::uint32_t index, const ShadingPoint& point, const Bsdf& bsdf, const ShadingFrame& frame) {
    const SunLight& sun = *scene_.lights.sun;
    const float sine = std::sqrt(sun.one_minus_cos * (2 - sun.one_minus_cos));
    if (glm::dot(sun.towards, point.geometric_normal) <= -sine)
        return;  // all of its disc is behind
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
            {{offset_origin(point.position, point.geometric_normal, point.reach), direction, infinity},
             contribution,
             index});
}

void Worker::sample_sky(std::uint32_t index, const ShadingPoint& point, const Bsdf& bsdf, const ShadingFrame& frame) {
    Path& path = paths_[index];
    SkyOpenings::Cell cell;
    if (scene_.openings && !scene_.openings->empty())
        cell = scene_.openings->at(point.position, point.normal);
    lit_by_ = cell.list;
    const float by_image = share_of_image(cell.list);
    if (cell.list.empty() && by_image == 0)
        return;
    // Russian roulette by what is to be expected; the means of cells hide bright spots.
    constexpr float min_probability = 0.05f;
    const float likely =
        cell.list.empty() ? 1 : std::clamp(largest(path.throughput) * cell.skylight, min_probability, 1.0f);
    if (likely < 1 && path.sampler.next_hashed() >= likely)
        return;
    glm::vec2 u = path.sampler.pair(path.vertices, Sampler::Use::sky);
    glm::vec3 direction;
    const bool is_by_image = u.x < by_image;
    if (is_by_image) {
        u.x /= by_image;
        direction = scene_.lights.sky_image->sample(u).direction;
    } else {
        u.x = (u.x - by_image) / (1 - by_image);
        direction = cell.list.sample(point.position, u);
    }
    if (glm::dot(direction, point.geometric_normal) <= 0)
        return;
    const float by_openings = cell.list.pdf(point.position, direction);
    if (!is_by_image && !(by_openings > 0))
        return;  // rounded out of its ball
    const float pdf = sky_pdf(cell.list, by_openings, direction);
    const BsdfValue scattered = bsdf.evaluate(frame.to_local(-path.direction), frame.to_local(direction));
    const glm::vec3 contribution = path.throughput * scattered.value * scene_.lights.sampled_sky(direction) *
                                   (power_heuristic(pdf, scattered.pdf) / (pdf * likely));
    if (largest(contribution) > 0)
        shadow_rays_.push_back(
            {{offset_origin(point.position, point.geometric_normal, point.reach), direction, infinity},
             contribution,
             index});
}

void Worker::sample_emitter(std::uint32_t index, const ShadingPoint& point, const Bsdf& bsdf,
                            const ShadingFrame& frame) {
    Path& path = paths_[index];
    double choice = path.sampler.pair(path.vertices, Sampler::Use::choices).y;
    if (scene_.lights.emitters.are_many())
        choice += double(path.sampler.next_hashed()) * 0x1p-24;
    const glm::vec2 u = path.sampler.pair(path.vertices, Sampler::Use::emitter);
    const EmitterSample emitter = scene_.lights.emitters.sample(choice, u);
    if (emitter.cut_away)
        return;
    const ShadingMaterial& material = scene_.shading.material(emitter.material);
    const glm::vec3 origin = offset_origin(point.position, point.geometric_normal, point.reach);
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
        shadow_rays_.push_back({{origin, direction, distance * 0.9999f}, contribution, index});
}

bool Worker::scatter(Path& path, const ShadingPoint& point, const Bsdf& bsdf, const ShadingFrame& frame,
                     const glm::vec3& albedo) {
    const float lobe = path.sampler.pair(path.vertices, Sampler::Use::choices).x;
    const glm::vec2 u = path.sampler.pair(path.vertices, Sampler::Use::scattering);
    const BsdfSample s = bsdf.sample(frame.to_local(-path.direction), lobe, u);
    ++path.vertices;
    if (s.kind == BsdfSample::Kind::none || s.kind == BsdfSample::Kind::rough || !(largest(s.weight) > 0))
        guide(path, albedo, point.normal);
    if (s.kind == BsdfSample::Kind::none || !(largest(s.weight) > 0))
        return false;
    path.throughput *= s.weight;
    if (s.kind == BsdfSample::Kind::straight) {
        path.origin = offset_origin(point.position, -point.geometric_normal, point.reach);
        return true;
    }
    if (path.bounces >= scene_.options.max_bounces)
        return false;
    path.direction = glm::normalize(frame.to_world(s.direction));
    if (glm::dot(path.direction, point.geometric_normal) <= 0)
        return false;
    path.origin = offset_origin(point.position, point.geometric_normal, point.reach);
    path.scatter_distance = 0;
    const bool rough = s.kind == BsdfSample::Kind::rough;
    path.next_event_done = rough && scene_.options.next_event;
    path.scatter_pdf = rough ? s.pdf : 0;
    path.openings = lit_by_;
    path.scattered_at = point.position;
    path.after_rough |= rough;
    if (rough && !scene_.options.unbiased)
        path.cone.spread_rad = std::max(path.cone.spread_rad, std::min(widest_spread_rad, 0.25f / std::sqrt(s.pdf)));
    if (++path.bounces <= bounces_before_roulette)
        return true;
    const float survival = std::min(1.0f, roulette_leniency * largest(path.throughput));
    if (path.sampler.next_hashed() >= survival)
        return false;
    path.throughput /= survival;
    return true;
}

}  // namespace equistream::embree_host
