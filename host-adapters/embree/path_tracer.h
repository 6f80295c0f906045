#pragma once
/// Shadow rays: what part of a light arrives through thin glass, alpha masks and nothing else.
#include "directions.h"
#include "lights.h"
#include "sampler.h"
#include "shading_scene.h"
#include "sky_openings.h"

#include <equistream/equistream.h>

#include <scenes/library/model.h>

#include <cstdint>
#include <ctime>
#include <span>
#include <vector>

namespace equistream::embree_host {

/// From a surface towards a light; `direction` is unit.
struct Segment {
    glm::vec3 origin, direction;
    float distance = 0;  ///< infinite for the sun
};

/// 0 where something opaque lies between, the product of the glass's tints otherwise.
glm::vec3 transmittance(const Bvh& bvh, const ShadingScene& scene, Textures::Reader& textures, const Segment& segment);

// Processor time of the calling thread, by stage. Read once a batch of rays, so that it costs next to nothing.

class StageClock {
public:
    StageClock() : last_s_(now_s()) {}

    /// Time since the last lap.
    double lap() {
        const double now = now_s();
        const double taken = now - last_s_;
        last_s_ = now;
        return taken;
    }

private:
    static double now_s() {
        timespec t{};
        clock_gettime(CLOCK_THREAD_CPUTIME_ID, &t);
        return static_cast<double>(t.tv_sec) + 1e-9 * static_cast<double>(t.tv_nsec);
    }
    double last_s_;
};

// A unidirectional path tracer over Embree: next-event estimation with multiple importance sampling (power
// heuristic) for the sun, emissive triangles, a sky that is an image and any sky that is seen through openings
// (sky_openings.h), BSDF sampling for a constant sky elsewhere, Russian roulette.
//
// What it leaves out unless PathOptions::unbiased is set, and why:
// - Past the first rough scattering, specular lobes of opaque surfaces are widened to the cone that the path has
//   become (alpha up to 0.3), mirrors too. Caustics come out blurred instead of as bright single pixels, which no
//   affordable number of samples would average away and every codec would spend its bits on.
// - Sunlight that glass reflects onto rough surfaces is dropped, for the same reason. Shadow rays pass through thin
//   glass, tinted, so sunlight and lamps behind windows are there.
// - After a rough scattering textures are read at a coarser level, as wide as that cone.
// Either way textures are filtered to a pixel's width, glass is thin and paths end after max_bounces.
//
// Threads: one Worker each; the shared objects are only read.

struct PathOptions {
    std::uint32_t max_bounces = default_max_bounces;  ///< scatterings, not counting straight passes through glass
    bool next_event = true;  ///< false: lights are found by BSDF sampling alone (slow; for tests)
    bool unbiased = false;   ///< true: nothing of the above; caustics are found by chance, as bright pixels
};

/// Everything a Worker reads. All borrowed.
struct TracedScene {
    const Bvh& bvh;
    const ShadingScene& shading;
    const Textures& textures;
    const Lights& lights;
    PathOptions options;
    const SkyOpenings* openings = nullptr;  ///< used with next-event estimation only; none: nullptr
};

/// What was done, and what it took.
struct RayCounts {
    std::uint64_t paths = 0;
    std::uint64_t path_rays = 0;    ///< closest hits, of colour and geometry rays
    std::uint64_t shadow_rays = 0;  ///< any hits
    std::uint64_t texture_calls = 0;
    std::uint64_t not_finite = 0;  ///< paths whose radiance is not: the film leaves them out
    // Processor time, all threads together, in seconds.
    double camera_rays_s = 0, path_rays_s = 0, shadow_rays_s = 0;
    double shading_s = 0;  ///< textures included
    double film_s = 0;     ///< in the plugin: making rays, taking answers

    RayCounts& operator+=(const RayCounts& o);
};

class Worker {
public:
    explicit Worker(const TracedScene& scene);

    /// One sample of each pixel: `pixel_seeds` is the same for all samples of a pixel. Writes RGBA per ray, and where
    /// `guides` is not empty, six numbers per ray (es_tile_put_guides); where `ids` is not, two (es_tile_put_ids).
    void trace_radiance(std::span<const es_ray> rays, std::span<const std::uint64_t> pixel_seeds, std::uint32_t sample,
                        std::span<float> rgba, std::span<float> guides = {}, std::span<std::uint32_t> ids = {});
    /// Closest hits of rays in order, a miss having no instance. Neighbouring rays should be coherent.
    struct Hit {
        HitId id;
        float distance = 0;
    };
    void trace_coherent(std::span<const es_ray> rays, std::vector<Hit>& hits);
    /// The closest hit of one ray.
    Hit trace(const glm::vec3& origin, const glm::vec3& direction);

    Textures::Reader& textures() { return textures_; }
    /// Counts the time since the last call of this or trace_radiance as shading: of geometry rays, and of those that a
    /// hidden layer asks for.
    void end_surfaces() { counts_.shading_s += clock_.lap(); }
    RayCounts counts() const;

private:
    struct Path {
        glm::vec3 origin, direction, throughput{1}, radiance{0};
        Sampler sampler;
        RayCone cone;
        float scatter_pdf = 0;         ///< of the last rough scattering
        OpeningList openings;          ///< that lit it
        glm::vec3 scattered_at{0};     ///< where it was
        float scatter_distance = 0;    ///< travelled since, straight passes through glass included
        std::uint8_t bounces = 0;      ///< scatterings but straight passes
        std::uint16_t vertices = 0;    ///< all
        bool covered = false;          ///< the camera ray hit something
        bool after_rough = false;      ///< some scattering was rough
        bool next_event_done = false;  ///< the last scattering (straight passes aside) was rough and sampled lights
        bool guided = false;           ///< the guides below are those of the first rough surface, or of its light
        glm::vec3 guide_albedo{0}, guide_normal{0};
    };
    struct ShadowRay {
        Segment segment;
        glm::vec3 contribution;
        std::uint32_t path;
    };

    void start_paths(std::span<const es_ray> rays, std::span<const std::uint64_t> pixel_seeds, std::uint32_t sample);
    void trace_paths();
    void shade_paths();
    void trace_shadow_rays();
    void escape(Path& path) const;
    glm::vec3 sky_radiance(Path& path) const;
    float share_of_image(const OpeningList& openings) const;
    float sky_pdf(const OpeningList& openings, float by_openings, const glm::vec3& direction) const;
    static void guide(Path& path, const glm::vec3& albedo, const glm::vec3& normal);
    /// False when the path ends here.
    bool shade(std::uint32_t index, const Hit& hit);
    void add_emission(Path& path, const ShadingMaterial& material, const ShadingPoint& point, float distance,
                      const glm::vec3& jitter);
    void sample_lights(std::uint32_t index, const ShadingPoint& point, const Bsdf& bsdf, const ShadingFrame& frame);
    void sample_sun(std::uint32_t index, const ShadingPoint& point, const Bsdf& bsdf, const ShadingFrame& frame);
    void sample_sky(std::uint32_t index, const ShadingPoint& point, const Bsdf& bsdf, const ShadingFrame& frame);
    void sample_emitter(std::uint32_t index, const ShadingPoint& point, const Bsdf& bsdf, const ShadingFrame& frame);
    bool scatter(Path& path, const ShadingPoint& point, const Bsdf& bsdf, const ShadingFrame& frame,
                 const glm::vec3& albedo);

    const TracedScene& scene_;
    Textures::Reader textures_;
    std::vector<Path> paths_;
    std::vector<std::uint32_t> active_;
    std::vector<Hit> hits_;  // of active_
    std::vector<ShadowRay> shadow_rays_;
    OpeningList lit_by_;  // of the surface that is shaded
    RayCounts counts_;
    StageClock clock_;
};

}  // namespace equistream::embree_host
