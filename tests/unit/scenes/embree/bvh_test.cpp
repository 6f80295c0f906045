#include <tests/unit/scenes/ray_tracing.h>
#include <tests/unit/scenes/temporary_folder.h>

#include <glm/gtc/matrix_transform.hpp>

#include <algorithm>
#include <array>

namespace equistream::test {

namespace {

SceneModel model_of(Mesh mesh) {
    SceneModel model;
    model.materials.emplace_back();
    mesh.material = 0;
    model.meshes.push_back(std::move(mesh));
    model.objects.emplace_back();
    model.instances.push_back({0, 0, glm::mat4(1)});
    return model;
}

/// A soup placed once, another placed thrice (once mirrored, once stretched), and one squashed flat.
constexpr std::uint32_t squashed_instance = 4;

SceneModel varied_scene() {
    std::mt19937 random(11);
    SceneModel model = model_of(triangle_soup(40, random));
    model.meshes.push_back(triangle_soup(40, random));
    model.meshes.push_back(triangle_soup(40, random));
    for (Mesh& mesh : model.meshes)
        mesh.material = 0;
    const glm::mat4 one(1);
    const auto at = [&](float x, float y, float z) { return glm::translate(one, {x, y, z}); };
    model.instances[0].world_from_object = at(0, 1, 0) * glm::rotate(one, 0.7f, glm::vec3(0.6f, 0.8f, 0));
    model.instances.push_back({1, 0, at(1, 0, 0) * glm::rotate(one, 1.0f, glm::vec3(0, 1, 0))});
    model.instances.push_back({1, 0, at(-1, 0, 0) * glm::scale(one, {-1, 1, 1})});
    model.instances.push_back({1, 0, at(0, 0, -1) * glm::scale(one, {2, 0.5f, 1})});
    model.instances.push_back({2, 0, at(0, -1, 0) * glm::scale(one, {1, 0, 1})});
    model.instances.push_back({2, 0, at(0, -1.5f, 0)});
    return model;
}

/// From anywhere around towards where things are.
Ray ray_through_the_middle(std::mt19937& random) {
    const glm::vec3 origin = 3.0f * random_direction(random);
    return {origin, glm::normalize(random_direction(random) - origin)};
}

/// Returns how many rays hit.
int expect_same_as_reference(const Bvh& bvh, const SceneModel& model, const std::vector<glm::mat4>& transforms,
                             unsigned seed) {
    std::mt19937 random(seed);
    int hits = 0;
    for (int i = 0; i < 3000; ++i) {
        const Ray ray = ray_through_the_middle(random);
        const ReferenceHits expected = trace_all(model, transforms, ray);
        const Hit found = trace(bvh, ray);
        // Rays that graze an edge or meet two surfaces at once may be decided either way.
        const float u = expected.nearest.id.u, v = expected.nearest.id.v;
        if (std::min({u, v, 1 - u - v}) < 1e-4f || expected.second - expected.nearest.distance < 1e-4)
            continue;
        if (std::isinf(expected.nearest.distance)) {
            EXPECT_TRUE(std::isinf(found.distance)) << "ray " << i;
            continue;
        }
        ++hits;
        EXPECT_NEAR(found.distance, expected.nearest.distance, 2e-5 * (1 + expected.nearest.distance)) << "ray " << i;
        EXPECT_EQ(found.id.instance, expected.nearest.id.instance) << "ray " << i;
        EXPECT_EQ(found.id.triangle, expected.nearest.id.triangle) << "ray " << i;
        EXPECT_NEAR(found.id.u, u, 2e-3) << "ray " << i;
        EXPECT_NEAR(found.id.v, v, 2e-3) << "ray " << i;
    }
    return hits;
}

}  // namespace

TEST(Bvh, DepthInsideAnIcosphere) {
    constexpr float radius = 3;
    const SceneModel model = model_of(icosphere(4, radius));
    ASSERT_EQ(model.triangle_count(), 20u * 256);
    // The flattest face decides: its plane is nearest to the centre.
    double nearest_plane = radius;
    for (const glm::uvec3& t : model.meshes[0].triangles) {
        const glm::dvec3 a(model.meshes[0].positions[t.x]), b(model.meshes[0].positions[t.y]);
        const glm::dvec3 c(model.meshes[0].positions[t.z]);
        nearest_plane = std::min(nearest_plane, std::abs(glm::dot(a, glm::normalize(glm::cross(b - a, c - a)))));
    }
    EXPECT_GT(nearest_plane, 0.997 * radius);
    const Bvh bvh(model);
    std::mt19937 random(5);
    for (int i = 0; i < 20000; ++i) {
        const double depth = trace(bvh, {{}, random_direction(random)}).distance;
        ASSERT_LE(depth, radius * (1 + 1e-6));
        ASSERT_GE(depth, nearest_plane * (1 - 1e-6));
    }
}

/// Rays at edges and everywhere, from the middle and from close to the surface, flat and instanced: none may slip
/// through. Rays at vertices may, where Embree's rounding decides all triangles around one against them, but rarely.
TEST(Bvh, ClosedSphereDoesNotLeak) {
    SceneModel model = model_of(icosphere(3, 1));
    const glm::mat4 turned = glm::rotate(glm::mat4(1), 0.3f, glm::vec3(0.36f, 0.48f, 0.8f));
    model.instances[0].world_from_object = turned;
    for (const bool instanced : {false, true}) {
        if (instanced)
            model.instances.push_back({0, 0, glm::translate(glm::mat4(1), {50, 0, 0})});
        const Bvh bvh(model);
        std::mt19937 random(8);
        int leaks = 0, leaks_at_vertices = 0, at_vertices = 0;
        const auto leaked = [&](const glm::vec3& origin, const glm::vec3& target) {
            return std::isinf(trace(bvh, {origin, glm::normalize(target - origin)}).distance) ? 1 : 0;
        };
        for (const glm::vec3& origin : {glm::vec3(0), glm::vec3(0.3f, -0.5f, 0.1f), glm::vec3(0, 0, 0.97f)})
            for (const glm::uvec3& t : model.meshes[0].triangles) {
                const std::array<glm::vec3, 3> p{glm::vec3(turned * glm::vec4(model.meshes[0].positions[t.x], 1)),
                                                 glm::vec3(turned * glm::vec4(model.meshes[0].positions[t.y], 1)),
                                                 glm::vec3(turned * glm::vec4(model.meshes[0].positions[t.z], 1))};
                for (std::size_t c = 0; c < 3; ++c) {
                    for (const float share : {0.25f, 0.5f, 0.7f})
                        leaks += leaked(origin, glm::mix(p[c], p[(c + 1) % 3], share));
                    leaks_at_vertices += leaked(origin, p[c]);
                    ++at_vertices;
                }
                leaks += leaked(origin, random_direction(random));
            }
        EXPECT_EQ(leaks, 0) << (instanced ? "instanced" : "flat");
        EXPECT_LT(leaks_at_vertices, at_vertices / 200) << (instanced ? "instanced" : "flat");
    }
}

TEST(Bvh, AgreesWithBruteForceFlatInstancedMirroredSingular) {
    const SceneModel model = varied_scene();
    const Bvh bvh(model);
    EXPECT_GT(expect_same_as_reference(bvh, model, rest_transforms(model), 21), 500);
    EXPECT_GT(bvh.memory_bytes(), 1000u);
}

TEST(Bvh, MovesInstancesAndOnlyThose) {
    const SceneModel model = varied_scene();
    const Bvh unmoved(model);
    Bvh bvh(model, {.moving_instances = {0, 2}});
    std::vector<glm::mat4> transforms = rest_transforms(model);
    EXPECT_GT(expect_same_as_reference(bvh, model, transforms, 22), 500);
    for (const float step : {0.5f, -0.75f}) {
        transforms[0] = glm::translate(glm::mat4(1), {step, 0.5f, 0.25f});
        transforms[2] = glm::rotate(transforms[2], step, glm::vec3(0, 0, 1));
        std::vector<glm::mat4> with_an_unlisted_one = transforms;
        with_an_unlisted_one[1] = glm::translate(glm::mat4(1), {0, 9, 0});
        bvh.move(with_an_unlisted_one);
        EXPECT_GT(expect_same_as_reference(bvh, model, transforms, 23), 500);
    }
}

TEST(Bvh, PacketsAndShadowRaysAgreeWithSingleRays) {
    const SceneModel model = varied_scene();
    const Bvh bvh(model);
    std::mt19937 random(31);
    int hits = 0;
    for (int round = 0; round < 200; ++round) {
        RayPacket packet;
        std::array<Ray, 16> rays;
        for (std::size_t i = 0; i < 16; ++i) {
            rays[i] = ray_through_the_middle(random);
            packet.start(i, rays[i].origin, rays[i].direction);
            packet.valid[i] = i % 5 == 4 ? 0 : -1;
        }
        bvh.intersect16(packet.valid.data(), packet.rays, round % 2 == 0);
        for (std::size_t i = 0; i < 16; ++i) {
            const Hit single = trace(bvh, rays[i]);
            const HitId id = bvh.resolve(packet.hit(i));
            if (!packet.started(i)) {
                EXPECT_EQ(id.instance, no_index);
                continue;
            }
            EXPECT_EQ(id.instance, single.id.instance);
            // The squashed triangles lie in one plane, over one another.
            EXPECT_TRUE(id.triangle == single.id.triangle || id.instance == squashed_instance);
            EXPECT_NEAR(std::min(packet.distance(i), 100.0f), std::min(single.distance, 100.0), 1e-5);
            RTCRay shadow = embree_ray(rays[i]).ray;
            EXPECT_EQ(bvh.occluded1(shadow), single.id.instance != no_index);
            hits += single.id.instance != no_index;
            if (single.id.instance != no_index) {
                RTCRay before = embree_ray(rays[i]).ray;
                before.tfar = static_cast<float>(single.distance * 0.999);
                EXPECT_FALSE(bvh.occluded1(before));
            }
        }
    }
    EXPECT_GT(hits, 500);
}

/// Vectors without spare room behind the last vertex must be copied, not shared: Embree reads 16 bytes there.
TEST(Bvh, TightVertexBuffers) {
    SceneModel model = model_of(icosphere(2, 1));
    model.meshes[0].positions.shrink_to_fit();
    const Bvh tight(model);
    model.meshes[0].positions.reserve(model.meshes[0].positions.size() + 1);
    const Bvh roomy(model);
    std::mt19937 random(2);
    for (int i = 0; i < 500; ++i) {
        const Ray ray{{}, random_direction(random)};
        EXPECT_EQ(trace(tight, ray).distance, trace(roomy, ray).distance);
    }
}

TEST(Bvh, RefusesNothingToTraceAndUnknownMovers) {
    SceneModel empty;
    expect_contains(input_error([&] { Bvh bvh(empty); }), "at least one triangle");
    const SceneModel model = model_of(icosphere(0, 1));
    expect_contains(input_error([&] { Bvh bvh(model, {.moving_instances = {1}}); }), "below 1");
}

}  // namespace equistream::test
