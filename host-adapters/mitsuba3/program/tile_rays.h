#pragma once
/// Tiles of rays that the plugin hands out, answered by Mitsuba: what a hidden layer is made of.
#include "world_map.h"

#include <host-adapters/common/host.h>

#include <functional>
#include <span>
#include <vector>

namespace equistream::mitsuba_host {

class TileRays {
public:
    TileRays(EmbeddedScene& scene, const WorldMap& world) : scene_(scene), world_(world) {}

    /// Fills the frame, or returns early when told to stop. Depth is the one geometry plane it knows. Returns samples
    /// that were not finite. `seed_of(tile, sample)` differs for each.
    std::uint64_t render(const render_command::FrameTask& task, std::size_t sensor,
                         const std::function<std::uint32_t(std::uint32_t, std::uint32_t)>& seed_of);

    /// How far rays go; +inf for a miss.
    std::vector<float> distances_m(std::span<const es_ray> rays);

private:
    /// In Mitsuba's world and units.
    RayBatch batch(std::span<const es_ray> rays) const;
    std::span<const es_ray> asked(std::uint32_t count) const { return std::span(rays_).first(count); }

    EmbeddedScene& scene_;
    const WorldMap& world_;
    std::vector<es_ray> rays_;
};

}  // namespace equistream::mitsuba_host
