#include "visibility.h"

#include "weld.h"

#include <scenes/embree/embree_rays.h>

#include <tbb/parallel_for.h>

#include <atomic>
#include <cmath>

namespace equistream {

namespace {

constexpr std::int64_t rays_of_a_sphere = std::int64_t{1} << 20;
constexpr int tries_a_triangle = 4;
/// Aimed rays end this part of their length before the triangle, which else might hide itself.
constexpr float clear_of_itself = 1 - 1e-4f;

void mark(std::uint8_t& flag) {
    std::atomic_ref<std::uint8_t>(flag).store(1, std::memory_order_relaxed);
}

bool is_marked(std::uint8_t& flag) {
    return std::atomic_ref<std::uint8_t>(flag).load(std::memory_order_relaxed) != 0;
}

/// Packets are squares of 4x4 jittered directions of one eye, so that they stay together.
void cast_sphere(const Bvh& bvh, const glm::dvec3& eye, int width, Random random, SeenTriangles& seen) {
    const EquirectCamera sphere{width, width / 2, {}};
    const double shift_u = random.unit(), shift_v = random.unit();
    tbb::parallel_for(0, sphere.height / 4, [&](int row) {
        trace_thread_init();
        for (int column = 0; column < width / 4; ++column) {
            RayPacket packet;
            for (int lane = 0; lane < 16; ++lane)
                packet.start(
                    std::size_t(lane), glm::vec3(eye),
                    glm::vec3(sphere.direction(column * 4 + lane % 4 + shift_u, row * 4 + lane / 4 + shift_v)));
            bvh.intersect16(packet.valid.data(), packet.rays, true);
            for (std::size_t lane = 0; lane < 16; ++lane) {
                const HitId hit = bvh.resolve(packet.hit(lane));
                if (hit.instance != no_index)
                    mark(seen[hit.instance][hit.triangle]);
            }
        }
    });
}

/// Random points of the triangle, from random eyes.
bool aim_at(const TriangleCorners& t, const Bvh& bvh, const HeadBoxes& boxes, Random& random) {
    for (int i = 0; i < tries_a_triangle; ++i) {
        const double root = std::sqrt(random.unit()), along = random.unit();
        const glm::dvec3 point =
            (1 - root) * glm::dvec3(t.a) + root * (1 - along) * glm::dvec3(t.b) + root * along * glm::dvec3(t.c);
        const glm::dvec3 eye = boxes.random_eye(random);
        RTCRay ray = embree_ray(glm::vec3(eye), glm::vec3(point - eye), clear_of_itself);
        if (!bvh.occluded1(ray))
            return true;
    }
    return false;
}

}  // namespace

SeenTriangles find_seen(const SceneModel& model, const Bvh& bvh, const HeadBoxes& boxes, std::int64_t rays,
                        std::uint64_t seed) {
    SeenTriangles seen(model.instances.size());
    for (std::size_t i = 0; i < seen.size(); ++i)
        seen[i].assign(model.meshes[model.instances[i].mesh].triangles.size(), 0);
    const int spheres = int(std::max<std::int64_t>(2, rays / rays_of_a_sphere));
    const int width = int(std::sqrt(2.0 * double(std::max<std::int64_t>(rays, 1 << 12)) / spheres)) / 8 * 8;
    Random random(seed);
    for (int i = 0; i < spheres; ++i) {
        const auto centre = boxes.centres()[std::size_t(i) * (boxes.centres().size() - 1) / std::size_t(spheres - 1)];
        // Most is seen from the box's skin.
        cast_sphere(bvh, centre + boxes.radius_m() * random.on_sphere(), width, Random(seed + std::uint64_t(i)), seen);
    }
    tbb::parallel_for(std::size_t{0}, seen.size(), [&](std::size_t i) {
        trace_thread_init();
        const Instance& instance = model.instances[i];
        const Mesh& mesh = model.meshes[instance.mesh];
        tbb::parallel_for(std::size_t{0}, (mesh.triangles.size() + 1023) / 1024, [&](std::size_t block) {
            trace_thread_init();
            Random own(seed ^ (std::uint64_t(i) << 32 | block));
            for (std::size_t t = block * 1024; t < std::min(mesh.triangles.size(), (block + 1) * 1024); ++t)
                if (!is_marked(seen[i][t]) && aim_at(corners_of(mesh, t, instance.world_from_object), bvh, boxes, own))
                    mark(seen[i][t]);
        });
    });
    return seen;
}

void add_neighbours(const Mesh& mesh, std::vector<std::uint8_t>& seen) {
    const std::vector<std::uint32_t> point = weld(mesh.positions);
    std::vector<std::uint8_t> touched(point.size(), 0);
    for (std::size_t t = 0; t < seen.size(); ++t)
        if (seen[t] != 0)
            for (int corner = 0; corner < 3; ++corner)
                touched[point[mesh.triangles[t][corner]]] = 1;
    for (std::size_t t = 0; t < seen.size(); ++t)
        for (int corner = 0; corner < 3; ++corner)
            seen[t] |= touched[point[mesh.triangles[t][corner]]];
}

}  // namespace equistream
