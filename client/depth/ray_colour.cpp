#include "ray_colour.h"

#include "base_textures.h"

#include <scenes/embree/embree_rays.h>

#include <tbb/blocked_range.h>
#include <tbb/parallel_for.h>
#include <tbb/task_arena.h>

#include <algorithm>
#include <cassert>
#include <cmath>
#include <future>
#include <limits>
#include <mutex>
#include <vector>

namespace equistream {

namespace {

constexpr std::size_t packet_size = 16;

/// Corners of a triangle that was hit.
struct Corners {
    glm::vec3 p[3];
    glm::vec2 uv[3];
};

}  // namespace

struct RayColour::State {
    struct Loaded {
        SceneModel model;
        Bvh bvh;
        BaseTextures textures;
        std::vector<glm::mat4> world_from_object;

        explicit Loaded(const SceneDescription& scene)
            : model(load_model(scene)), bvh(model, {.moving_instances = find_moving_instances(model, scene)}),
              textures(model) {}

        void move(const SceneDescription& scene, double time_s) {
            world_from_object = instance_transforms(model, scene, time_s);
            if (!scene.moving.empty())
                bvh.move(world_from_object);
        }
        /// no_index where the surface has one colour.
        std::uint32_t texture_of(const HitId& id) const;
        GeometryHit shade(const GeometryRay& ray, const HitId& id, float distance_m) const;
        Corners corners(const HitId& id) const;
    };

    SceneDescription scene;
    double time_s = 0;
    bool moved = true;
    std::mutex mutex;
    std::unique_ptr<Loaded> loaded;
    std::future<std::unique_ptr<Loaded>> loading;  ///< last, so that it ends before what it reads

    /// What was hit, by ray.
    struct Hits {
        std::vector<HitId> ids;
        std::vector<float> distances_m;  ///< +inf for a miss
    };
    void trace(std::span<const GeometryRay> rays, Hits& hits) const;
    void decode_textures(const Hits& hits) const;
};

Corners RayColour::State::Loaded::corners(const HitId& id) const {
    const Mesh& mesh = model.meshes[model.instances[id.instance].mesh];
    const glm::uvec3 triangle = mesh.triangles[id.triangle];
    Corners corners{};
    for (int i = 0; i < 3; ++i) {
        corners.p[i] = glm::vec3(world_from_object[id.instance] * glm::vec4(mesh.positions[triangle[i]], 1));
        if (!mesh.uvs.empty())
            corners.uv[i] = mesh.uvs[triangle[i]];
    }
    return corners;
}

std::uint32_t RayColour::State::Loaded::texture_of(const HitId& id) const {
    const Mesh& mesh = model.meshes[model.instances[id.instance].mesh];
    if (mesh.uvs.empty())
        return no_index;
    return model.materials[mesh.material == no_index ? model.materials.size() - 1 : mesh.material].base_colour_texture;
}

GeometryHit RayColour::State::Loaded::shade(const GeometryRay& ray, const HitId& id, float distance_m) const {
    const Mesh& mesh = model.meshes[model.instances[id.instance].mesh];
    const Material& material = model.materials[mesh.material == no_index ? model.materials.size() - 1 : mesh.material];
    const Corners c = corners(id);
    const glm::vec3 cross = glm::cross(c.p[1] - c.p[0], c.p[2] - c.p[0]);
    const float area = glm::length(cross);
    GeometryHit hit{.distance_m = distance_m, .base_colour = material.base_colour, .instance = id.instance};
    hit.normal = area > 0 ? cross / area : -ray.direction;
    const float cosine = glm::dot(hit.normal, ray.direction);
    if (cosine > 0)
        hit.normal = -hit.normal;
    if (texture_of(id) != no_index) {
        const glm::vec2 a = c.uv[1] - c.uv[0], b = c.uv[2] - c.uv[0];
        const float uv_per_m = std::sqrt(std::abs(a.x * b.y - a.y * b.x) / std::max(area, min_triangle_m2));
        const glm::vec2 uv = (1 - id.u - id.v) * c.uv[0] + id.u * c.uv[1] + id.v * c.uv[2];
        const float width_m = ray.spread_rad * distance_m / std::sqrt(std::max(std::abs(cosine), min_seen_cosine));
        hit.base_colour *= textures.lookup(material.base_colour_texture, uv, width_m * uv_per_m);
    }
    hit.matte = is_matte(material);
    return hit;
}

RayColour::RayColour(const SceneDescription& scene) : state_(std::make_unique<State>()) {
    state_->scene = scene;
}

RayColour::~RayColour() = default;

void RayColour::set_time(double time_s) {
    state_->moved = state_->moved || time_s != state_->time_s;
    state_->time_s = time_s;
}

void RayColour::start_loading() {
    State& state = *state_;
    state.loading =
        std::async(std::launch::async, [&scene = state.scene] { return std::make_unique<State::Loaded>(scene); });
}

void RayColour::State::trace(std::span<const GeometryRay> rays, Hits& hits) const {
    hits.ids.resize(rays.size());
    hits.distances_m.assign(rays.size(), std::numeric_limits<float>::infinity());
    const std::size_t packets = (rays.size() + packet_size - 1) / packet_size;
    tbb::parallel_for(tbb::blocked_range<std::size_t>(0, packets, 16), [&](const auto& range) {
        trace_thread_init();
        for (std::size_t packet = range.begin(); packet < range.end(); ++packet) {
            RayPacket trace;
            const std::size_t first = packet * packet_size;
            const std::size_t count = std::min(packet_size, rays.size() - first);
            for (std::size_t lane = 0; lane < count; ++lane)
                trace.start(lane, rays[first + lane].origin_m, rays[first + lane].direction);
            loaded->bvh.intersect16(trace.valid.data(), trace.rays, true);
            for (std::size_t lane = 0; lane < count; ++lane) {
                const RTCHit hit = trace.hit(lane);
                if (hit.geomID == RTC_INVALID_GEOMETRY_ID)
                    continue;
                hits.ids[first + lane] = loaded->bvh.resolve(hit);
                hits.distances_m[first + lane] = trace.distance(lane);
            }
        }
    });
}

/// Each by one thread and as many at once as there are threads: met one after the other while shading, every thread
/// would wait for the one that decodes.
void RayColour::State::decode_textures(const Hits& hits) const {
    std::vector<std::uint8_t> met(loaded->model.textures.size());
    for (std::size_t i = 0; i < hits.ids.size(); ++i)
        if (std::isfinite(hits.distances_m[i]))
            if (const std::uint32_t texture = loaded->texture_of(hits.ids[i]); texture != no_index)
                met[texture] = 1;
    tbb::parallel_for(std::size_t{0}, met.size(), [&](std::size_t texture) {
        if (met[texture] != 0)
            loaded->textures.decode(std::uint32_t(texture));
    });
}

void RayColour::cast(std::span<const GeometryRay> rays, std::span<GeometryHit> hits) {
    assert(rays.size() == hits.size());
    State& state = *state_;
    const std::scoped_lock lock(state.mutex);
    // Isolated, so that no thread takes up other work that waits for this very lock.
    tbb::this_task_arena::isolate([&] {
        if (!state.loaded)
            state.loaded = state.loading.valid() ? state.loading.get() : std::make_unique<State::Loaded>(state.scene);
        if (state.moved)
            state.loaded->move(state.scene, state.time_s);
        state.moved = false;
        State::Hits found;
        state.trace(rays, found);
        state.decode_textures(found);
        tbb::parallel_for(tbb::blocked_range<std::size_t>(0, rays.size(), 256), [&](const auto& range) {
            for (std::size_t i = range.begin(); i < range.end(); ++i)
                hits[i] = std::isfinite(found.distances_m[i])
                              ? state.loaded->shade(rays[i], found.ids[i], found.distances_m[i])
                              : GeometryHit{};
        });
    });
}

}  // namespace equistream
