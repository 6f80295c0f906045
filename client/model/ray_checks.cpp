#include "ray_checks.h"

#include "simplify.h"

#include <equistream/bound.h>

#include <scenes/embree/embree_rays.h>

#include <tbb/blocked_range.h>
#include <tbb/parallel_for.h>

#include <algorithm>
#include <array>
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
    // Each cell has its own: of a long path's length, what one room takes is little.
    const std::span<const glm::dvec3> starts = boxes.points_on_path();
    const auto cells = std::int64_t(boxes.cell_m() > 0 ? starts.size() : 0);
    const int spheres = int(std::max({std::int64_t{2}, rays / rays_of_a_sphere, cells}));
    const int width =
        std::max(8, int(std::sqrt(2.0 * double(std::max<std::int64_t>(rays, 1 << 12)) / spheres)) / 8 * 8);
    Random random(seed);
    for (int i = 0; i < spheres; ++i) {
        const glm::dvec3& start = starts[std::size_t(i) * (starts.size() - 1) / std::size_t(spheres - 1)];
        // Most is seen from the box's skin.
        cast_sphere(bvh, start + boxes.radius_m() * random.on_sphere(), width, Random(seed + std::uint64_t(i)), seen);
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

namespace {

constexpr std::int64_t rays_of_a_task = 4096;
/// Rings around a failing ray, as parts of silhouette_rad, with this many rays each.
constexpr std::array rings = {0.125, 0.25, 0.5, 0.75, 1.0};
constexpr int rays_of_a_ring = 12;
constexpr double same_inside_box = 1e-3;
constexpr std::array quantiles = {0.5, 0.99, 0.999, 0.9999};

struct Shot {
    double distance_m = 0;  ///< +inf for a miss
    HitId hit;
};

Shot shoot(const Bvh& bvh, const glm::dvec3& eye, const glm::dvec3& direction) {
    RTCRayHit ray = embree_ray_hit(glm::vec3(eye), glm::vec3(direction));
    bvh.intersect1(ray);
    return {double(ray.ray.tfar), bvh.resolve(ray.hit)};
}

double displacement_rad(double a_m, double b_m, double box_radius_m) {
    if (a_m <= box_radius_m || b_m <= box_radius_m)
        return std::abs(a_m - b_m) <= same_inside_box * std::max(a_m, b_m) ? 0 : 0.5 * pi;
    return displacement_bound_rad(a_m, b_m, box_radius_m);
}

/// What one task found; put together in order, so that the result does not depend on the threads.
struct Found {
    RayCheck counts;
    std::vector<float> displacements_rad, edge_shifts_rad;
    std::vector<FailedRay> failed;
};

class Checker {
public:
    Checker(const Bvh& scene, const Bvh& model, const HeadBoxes& boxes, const CheckSettings& settings)
        : scene_(scene), model_(model), boxes_(boxes), settings_(settings) {}

    Found task(std::int64_t number, std::int64_t rays) const {
        Found found;
        Random random(settings_.seed * 0x9e3779b97f4a7c15u + std::uint64_t(number));
        for (std::int64_t i = 0; i < rays; ++i) {
            const glm::dvec3 eye = boxes_.random_eye(random), direction = random.on_sphere();
            add(eye, direction, found);
        }
        return found;
    }

private:
    void add(const glm::dvec3& eye, const glm::dvec3& direction, Found& found) const {
        const Shot truth = shoot(scene_, eye, direction), ours = shoot(model_, eye, direction);
        const double shift = displacement_rad(truth.distance_m, ours.distance_m, boxes_.radius_m());
        ++found.counts.rays;
        if (shift <= settings_.error_rad) {
            ++found.counts.within;
            found.displacements_rad.push_back(float(shift));
            return;
        }
        const double edge = edge_shift_rad(eye, direction, truth, ours);
        if (edge <= settings_.silhouette_rad) {
            ++found.counts.at_edges;
            found.edge_shifts_rad.push_back(float(edge));
            return;
        }
        ++found.counts.failing;
        found.displacements_rad.push_back(float(shift));
        found.failed.push_back({truth.hit, ours.hit});
    }

    /// The smallest ring on which one side shows what the other shows in the middle; infinite if none does.
    double edge_shift_rad(const glm::dvec3& eye, const glm::dvec3& direction, const Shot& truth,
                          const Shot& ours) const {
        const glm::dvec3 helper = std::abs(direction.y) < 0.9 ? glm::dvec3(0, 1, 0) : glm::dvec3(1, 0, 0);
        const glm::dvec3 across = glm::normalize(glm::cross(helper, direction)), up = glm::cross(direction, across);
        const auto same = [&](double a_m, double b_m) {
            return displacement_rad(a_m, b_m, boxes_.radius_m()) <= settings_.error_rad;
        };
        for (const double ring : rings)
            for (int i = 0; i < rays_of_a_ring; ++i) {
                const double angle = 2 * pi * (i + 0.5) / rays_of_a_ring,
                             radius = std::tan(ring * settings_.silhouette_rad);
                const glm::dvec3 beside =
                    glm::normalize(direction + radius * (std::cos(angle) * across + std::sin(angle) * up));
                if (same(shoot(scene_, eye, beside).distance_m, ours.distance_m) ||
                    same(shoot(model_, eye, beside).distance_m, truth.distance_m))
                    return ring * settings_.silhouette_rad;
            }
        return std::numeric_limits<double>::infinity();
    }

    const Bvh& scene_;
    const Bvh& model_;
    const HeadBoxes& boxes_;
    CheckSettings settings_;
};

std::array<double, 4> quantiles_of(std::vector<float>& values) {
    std::array<double, 4> at{};
    std::sort(values.begin(), values.end());
    for (std::size_t i = 0; i < at.size() && !values.empty(); ++i)
        at[i] = values[std::min(values.size() - 1, std::size_t(quantiles[i] * double(values.size())))];
    return at;
}

}  // namespace

RayCheck check_by_rays(const Bvh& scene, const Bvh& model, const HeadBoxes& boxes, const CheckSettings& settings,
                       std::vector<FailedRay>& failed) {
    const Checker checker(scene, model, boxes, settings);
    std::vector<Found> found(std::size_t((settings.rays + rays_of_a_task - 1) / rays_of_a_task));
    tbb::parallel_for(std::size_t{0}, found.size(), [&](std::size_t i) {
        trace_thread_init();
        found[i] =
            checker.task(std::int64_t(i), std::min(rays_of_a_task, settings.rays - std::int64_t(i) * rays_of_a_task));
    });
    RayCheck check;
    std::vector<float> displacements, edges;
    for (const Found& part : found) {
        check.rays += part.counts.rays;
        check.within += part.counts.within;
        check.at_edges += part.counts.at_edges;
        check.failing += part.counts.failing;
        displacements.insert(displacements.end(), part.displacements_rad.begin(), part.displacements_rad.end());
        edges.insert(edges.end(), part.edge_shifts_rad.begin(), part.edge_shifts_rad.end());
        failed.insert(failed.end(), part.failed.begin(), part.failed.end());
    }
    check.displacement_rad = quantiles_of(displacements);
    check.edge_shift_rad = quantiles_of(edges);
    return check;
}

}  // namespace equistream
