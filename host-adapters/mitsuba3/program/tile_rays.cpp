#include "tile_rays.h"

#include <equistream/error.h>

#include <algorithm>
#include <cmath>

namespace equistream::mitsuba_host {

RayBatch TileRays::batch(std::span<const es_ray> rays) const {
    RayBatch batch;
    const glm::dmat3 turned = glm::transpose(world_.ours_from_mitsuba);
    const auto scale = static_cast<float>(1 / world_.metres_per_unit);
    for (const es_ray& ray : rays) {
        const glm::dvec3 origin = turned * glm::dvec3(ray.origin[0], ray.origin[1], ray.origin[2]);
        const glm::dvec3 direction = turned * glm::dvec3(ray.direction[0], ray.direction[1], ray.direction[2]);
        for (int axis = 0; axis < 3; ++axis) {
            const auto at = static_cast<std::size_t>(axis);
            batch.origin[at].push_back(static_cast<float>(origin[axis] / world_.metres_per_unit));
            batch.direction[at].push_back(static_cast<float>(direction[axis]));
        }
        batch.begin.push_back(ray.t_min * scale);
        batch.end.push_back(ray.t_max * scale);
    }
    return batch;
}

std::vector<float> TileRays::distances_m(std::span<const es_ray> rays) {
    std::vector<float> distances = scene_.distances(batch(rays));
    for (float& distance : distances)
        distance *= static_cast<float>(world_.metres_per_unit);
    return distances;
}

std::uint64_t TileRays::render(const render_command::FrameTask& task, std::size_t sensor,
                               const std::function<std::uint32_t(std::uint32_t, std::uint32_t)>& seed_of) {
    es_tile tile;
    std::uint64_t left_out = 0;
    while (!*task.stop) {
        const es_status status = es_frame_next_tile(task.frame, &tile);
        if (status == ES_DONE)
            break;
        if (status != ES_OK)
            throw WorkError("libequistream could not hand out the frame's next tile (status " + std::to_string(status) +
                            ")");
        rays_.resize(tile.pixel_count);
        while (const std::uint32_t count = es_tile_probe_rays(task.frame, &tile, rays_.data()))
            es_tile_put_distances(task.frame, &tile, distances_m(asked(count)).data());
        const std::uint32_t pixels = es_tile_geometry_rays(task.frame, &tile, rays_.data());
        std::vector<es_surface> surfaces(tile.pixel_count);
        const std::vector<float> distances = distances_m(asked(pixels));
        for (std::uint32_t i = 0; i < pixels; ++i)
            surfaces[i].distance_m = distances[i];
        es_tile_put_surfaces(task.frame, &tile, surfaces.data());
        for (std::uint32_t sample = 0; sample < tile.sample_count && !*task.stop; ++sample) {
            const std::uint32_t count = es_tile_colour_rays(task.frame, &tile, sample, rays_.data());
            std::vector<float> rgba = scene_.radiance(batch(asked(count)), sensor, seed_of(tile.id, sample));
            for (std::size_t i = 0; i < rgba.size(); i += 4)
                left_out += !std::all_of(&rgba[i], &rgba[i] + 4, [](float v) { return std::isfinite(v); });
            rgba.resize(std::max<std::size_t>(rgba.size(), 4));  // no pointer to nothing
            es_tile_put_radiance(task.frame, &tile, rgba.data());
            task.paths_traced(count);
        }
    }
    return left_out;
}

}  // namespace equistream::mitsuba_host
