#include <scenes/embree/bvh_build.h>
#include <tests/unit/scenes/ray_tracing.h>

#include <glm/gtc/matrix_transform.hpp>
#include <gtest/gtest.h>

#include <limits>
#include <random>

namespace equistream::test {

namespace {

/// A unit square in the plane z = -1, texture coordinates equal to x and 1 - y, cut by a checkerboard of 8x8 texels;
/// a plain square lies behind it at z = -2.
SceneModel checkerboard() {
    SceneModel model;
    AlphaMask mask;
    mask.width = mask.height = 8;
    for (int y = 0; y < 8; ++y)
        for (int x = 0; x < 8; ++x)
            mask.opaque.push_back((x + y) % 2 == 0 ? 255 : 0);
    model.alpha_masks.push_back(mask);
    model.materials.resize(2);
    model.materials[0].alpha_mask = 0;
    model.objects.emplace_back();
    for (std::uint32_t i = 0; i < 2; ++i) {
        Mesh mesh;
        const float z = -1 - static_cast<float>(i);
        mesh.positions = {{0, 0, z}, {1, 0, z}, {0, 1, z}, {1, 1, z}};
        mesh.uvs = {{0, 1}, {1, 1}, {0, 0}, {1, 0}};
        mesh.triangles = {{0, 1, 2}, {2, 1, 3}};
        mesh.material = i;
        model.meshes.push_back(mesh);
        model.instances.push_back({i, 0, glm::mat4(1)});
    }
    return model;
}

void expect_checkerboard(const Bvh& bvh, const glm::vec3& offset) {
    std::mt19937 random(17);
    std::uniform_real_distribution<float> uniform(0.001f, 0.999f);
    for (int i = 0; i < 2000; ++i) {
        const glm::vec3 origin(uniform(random), uniform(random), 0);
        const int column = static_cast<int>(origin.x * 8), row = static_cast<int>((1 - origin.y) * 8);
        const bool opaque = (column + row) % 2 == 0;
        const Ray ray{origin + offset, {0, 0, -1}};
        const Hit hit = trace(bvh, ray);
        EXPECT_NEAR(hit.distance, opaque ? 1 : 2, 1e-6) << origin.x << " " << origin.y;
        RTCRay shadow = embree_ray(ray).ray;
        shadow.tfar = 1.5f;
        EXPECT_EQ(bvh.occluded1(shadow), opaque) << origin.x << " " << origin.y;
    }
}

}  // namespace

TEST(BvhMask, HolesLetRaysAndShadowsThrough) {
    const SceneModel model = checkerboard();
    expect_checkerboard(Bvh(model), {0, 0, 0});
}

TEST(BvhMask, HolesInInstancesAndMovedInstances) {
    SceneModel model = checkerboard();
    const glm::mat4 aside = glm::translate(glm::mat4(1), {5, 0, 0});
    for (std::uint32_t mesh = 0; mesh < 2; ++mesh)
        model.instances.push_back({mesh, 0, aside});
    const Bvh bvh(model);
    expect_checkerboard(bvh, {0, 0, 0});
    expect_checkerboard(bvh, {5, 0, 0});
    Bvh moving(model, {.moving_instances = {2, 3}});
    const glm::mat4 there = glm::translate(glm::mat4(1), {0, 7, 0});
    moving.move(std::vector<glm::mat4>{glm::mat4(1), glm::mat4(1), there, there});
    expect_checkerboard(moving, {0, 0, 0});
    expect_checkerboard(moving, {0, 7, 0});
}

TEST(BvhMask, PacketsSeeTheSameHoles) {
    const SceneModel model = checkerboard();
    const Bvh bvh(model);
    RayPacket packet;
    for (std::size_t i = 0; i < 16; ++i)
        packet.start(i, {(static_cast<float>(i % 8) + 0.5f) / 8, 1 - (static_cast<float>(i / 8) + 0.5f) / 8, 0},
                     {0, 0, -1});
    bvh.intersect16(packet.valid.data(), packet.rays);
    for (std::size_t i = 0; i < 16; ++i)
        EXPECT_NEAR(packet.distance(i), (i % 8 + i / 8) % 2 == 0 ? 1 : 2, 1e-6) << "ray " << i;
}

}  // namespace equistream::test

namespace equistream {
namespace {

AlphaMask random_mask(int width, int height, Wrap wrap_u, Wrap wrap_v, std::mt19937& random) {
    AlphaMask mask;
    mask.width = width;
    mask.height = height;
    mask.wrap_u = wrap_u;
    mask.wrap_v = wrap_v;
    for (int i = 0; i < width * height; ++i)
        mask.opaque.push_back(random() % 2 ? 255 : 0);
    return mask;
}

TEST(MaskBits, AgreeWithTheMaskTheyWereMadeFrom) {
    std::mt19937 random(7);
    std::uniform_real_distribution<float> coordinate(-3, 3);
    for (const auto& [width, height] : {std::pair{1, 1}, {8, 8}, {13, 5}, {64, 130}})
        for (const Wrap wrap_u : {Wrap::repeat, Wrap::clamp, Wrap::mirror})
            for (const Wrap wrap_v : {Wrap::repeat, Wrap::clamp}) {
                const AlphaMask mask = random_mask(width, height, wrap_u, wrap_v, random);
                const MaskBits bits(mask);
                for (int i = 0; i < 2000; ++i) {
                    const glm::vec2 uv{coordinate(random), coordinate(random)};
                    EXPECT_EQ(bits.covers(uv), mask.covers(uv)) << width << "x" << height << " " << uv.x << " " << uv.y;
                }
                for (const float odd : {0.0f, -0.0f, 1.0f, -1.0f, -1e-9f, 3e7f, std::numeric_limits<float>::quiet_NaN(),
                                        std::numeric_limits<float>::infinity()})
                    EXPECT_EQ(bits.covers({odd, 0.3f}), mask.covers({odd, 0.3f})) << odd;
            }
}

}  // namespace
}  // namespace equistream
