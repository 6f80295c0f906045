#include "surfaces.h"

#include <cassert>
#include <limits>

namespace equistream::embree_host {
namespace {

glm::vec3 object_space_point(const Mesh& mesh, const HitId& hit) {
    const glm::uvec3 t = mesh.triangles[hit.triangle];
    return (1 - hit.u - hit.v) * mesh.positions[t.x] + hit.u * mesh.positions[t.y] + hit.v * mesh.positions[t.z];
}

es_surface surface_of(Worker& worker, const SurfacesScene& of, const es_ray& ray, const Worker::Hit& hit) {
    const ShadingScene& scene = of.shading;
    es_surface s{};
    if (hit.id.instance == no_index) {
        s.distance_m = std::numeric_limits<float>::infinity();
        return s;
    }
    const glm::vec3 direction = to_vec3(ray.direction);
    const ShadingPoint point = scene.surface_at(hit.id, to_vec3(ray.origin), direction, hit.distance);
    const SurfaceParameters parameters = surface_parameters(
        scene.material(point.material), point, ray.footprint_rad * hit.distance, glm::vec3(0.5f), worker.textures());
    const Instance& instance = scene.model().instances[hit.id.instance];
    s.distance_m = hit.distance;
    const NeighbourPoints moved = neighbour_points(of, hit.id, point.position);
    store(moved.previous, s.position_previous_m);
    store(moved.next, s.position_next_m);
    store(point.normal, s.normal);
    store(parameters.base_colour, s.albedo);
    s.object_id = instance.object + 1;
    s.material_id = point.material + 1;
    s.instance_id = hit.id.instance + 1;
    if (Bsdf(parameters, glm::dot(point.normal, -direction)).is_sharp()) {
        s.specular = 1;
        follow_sharp_path(worker, of, ray, hit, s);
    }
    return s;
}

}  // namespace

NeighbourPoints neighbour_points(const SurfacesScene& scene, const HitId& hit, const glm::vec3& position) {
    const NeighbourTransforms& neighbours = scene.neighbours;
    if (!neighbours.moves[hit.instance])
        return {position, position};
    const SceneModel& model = scene.shading.model();
    const glm::vec4 p(object_space_point(model.meshes[model.instances[hit.instance].mesh], hit), 1);
    return {glm::vec3(neighbours.previous[hit.instance] * p), glm::vec3(neighbours.next[hit.instance] * p)};
}

void trace_surfaces(Worker& worker, const SurfacesScene& scene, std::span<const es_ray> rays,
                    std::span<es_surface> surfaces) {
    assert(rays.size() == surfaces.size());
    std::vector<Worker::Hit> hits;
    worker.trace_coherent(rays, hits);
    for (std::size_t i = 0; i < rays.size(); ++i)
        surfaces[i] = surface_of(worker, scene, rays[i], hits[i]);
    worker.end_surfaces();
}

}  // namespace equistream::embree_host
