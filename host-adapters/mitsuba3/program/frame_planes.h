#pragma once
/// Passes of Mitsuba's film gathered into the planes of a frame.
#include "scene_source.h"
#include "world_map.h"

#include <host-adapters/common/host.h>

#include <functional>
#include <span>
#include <vector>

namespace equistream::mitsuba_host {

class FramePlanes {
public:
    /// `aovs`: groups that the passes bring.
    FramePlanes(int width, int height, std::string_view aovs);

    void add(const PassResult& pass, std::uint32_t samples);
    /// In Mitsuba's world until now; from here on in ours. The sun's disc, which no frame of ours shows, becomes a
    /// miss.
    void bring_home(const WorldMap& world);
    /// Those of `aovs` alone. `without_samples`: colour where no sample was finite. Throws WorkError with the plugin's
    /// words.
    void hand_over(es_frame* frame, std::string_view aovs, float without_samples) const;

    /// Samples that were not finite; each pass of a pixel counts as its samples.
    std::uint64_t left_out_samples() const { return left_out_; }

private:
    struct Plane {
        std::string name;
        int channels = 0;
        bool is_id = false;
        std::vector<float> values;
        std::vector<std::uint32_t> ids;
    };
    Plane* find(std::string_view name);
    void take_aovs(const PassResult& pass);
    void hand_over_guides(es_frame* frame) const;

    int width_, height_;
    std::vector<double> colour_;               // sums, as all below
    std::vector<std::uint32_t> good_samples_;  // of each pixel's colour
    std::vector<double> guides_;               // where passes bring them
    double all_samples_ = 0;                   // of a pixel's alpha and guides
    std::vector<Plane> planes_;
    std::uint64_t left_out_ = 0;
};

// Tiles of rays that the plugin hands out, answered by Mitsuba: what a hidden layer is made of.

class TileRays {
public:
    /// `axis`: unit, of a flat view, in our world: the sensor's clipping distances count along it. 0: along each ray.
    TileRays(EmbeddedScene& scene, const WorldMap& world, const glm::dvec3& axis = glm::dvec3(0))
        : scene_(scene), world_(world), axis_(axis) {}

    /// Fills the frame, or returns early when told to stop. Depth is the one geometry plane it knows, and that and
    /// colour are left out where they were handed over whole. Returns samples that were not finite.
    /// `seed_of(tile, sample)` differs for each.
    std::uint64_t render(const render_command::FrameTask& task, std::size_t sensor, bool ids_alone,
                         const std::function<std::uint32_t(std::uint32_t, std::uint32_t)>& seed_of);

    /// How far rays go; +inf for a miss.
    std::vector<float> distances_m(std::span<const es_ray> rays);

private:
    void put_distances(es_frame* frame, const es_tile& tile);
    /// Of every ray, in our world.
    std::vector<float> guides(const RayBatch& rays) const;
    /// In Mitsuba's world and units.
    RayBatch batch(std::span<const es_ray> rays) const;
    std::span<const es_ray> asked(std::uint32_t count) const { return std::span(rays_).first(count); }

    EmbeddedScene& scene_;
    const WorldMap& world_;
    glm::dvec3 axis_;
    std::vector<es_ray> rays_;
};

}  // namespace equistream::mitsuba_host
