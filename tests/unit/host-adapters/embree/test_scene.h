#pragma once
/// Small scenes built in code, and the mean and error of what a ray sees in them.
#include <host-adapters/embree/path_tracer.h>
#include <host-adapters/embree/surfaces.h>

#include <gtest/gtest.h>

#include <cmath>
#include <memory>

namespace equistream::embree_host {

inline es_ray make_ray(const glm::vec3& origin, const glm::vec3& direction, std::uint64_t seed = 1) {
    const glm::vec3 d = glm::normalize(direction);
    es_ray ray{};
    ray.t_max = std::numeric_limits<float>::infinity();
    for (int i = 0; i < 3; ++i) {
        ray.origin[i] = origin[i];
        ray.direction[i] = d[i];
    }
    ray.seed = seed;
    ray.footprint_rad = 0.002f;
    return ray;
}

inline Material matte(const glm::vec3& colour) {
    Material m;
    m.base_colour = colour;
    m.metallic = 0;
    m.roughness = 1;
    m.index_of_refraction = 1;  // no specular lobe
    m.double_sided = true;
    return m;
}

/// Cuts every second of `side` x `side` cells away.
inline AlphaMask checker_mask(int side) {
    AlphaMask mask;
    mask.width = mask.height = side;
    for (int i = 0; i < side * side; ++i)
        mask.opaque.push_back((i % side + i / side) % 2 ? 255 : 0);
    return mask;
}

struct MeanRadiance {
    glm::dvec3 mean{0};
    double standard_error = 0;  ///< of the green channel
};

/// Whether two estimates agree within three standard errors, which have to be small enough to tell anything.
inline testing::AssertionResult same_mean(const MeanRadiance& a, const MeanRadiance& b) {
    const double sigma = std::hypot(a.standard_error, b.standard_error), apart = std::abs(a.mean.y - b.mean.y);
    if (apart <= 3 * sigma && sigma < 0.02 * b.mean.y)
        return testing::AssertionSuccess();
    return testing::AssertionFailure() << a.mean.y << " and " << b.mean.y << ", standard error " << sigma;
}

class TestScene {
public:
    SceneModel model;
    Lights lights;
    PathOptions options;
    SkyOpenings openings;

    std::uint32_t add_material(const Material& material) {
        model.materials.push_back(material);
        return static_cast<std::uint32_t>(model.materials.size() - 1);
    }
    /// Adds a mesh and an instance of it as its own object; returns the instance.
    std::uint32_t add(Mesh mesh, const glm::mat4& world_from_object = glm::mat4(1)) {
        model.meshes.push_back(std::move(mesh));
        const auto object = static_cast<std::uint32_t>(model.objects.size());
        model.objects.push_back({"object " + std::to_string(object), -1, world_from_object});
        model.instances.push_back({static_cast<std::uint32_t>(model.meshes.size() - 1), object, world_from_object});
        return static_cast<std::uint32_t>(model.instances.size() - 1);
    }

    const TracedScene& build(std::vector<std::uint32_t> moving = {}) {
        if (model.materials.empty())
            add_material(matte(glm::vec3(0.5f)));
        textures_ = std::make_unique<Textures>(model);
        shading = std::make_unique<ShadingScene>(model);
        bvh = std::make_unique<Bvh>(model, BvhOptions{std::move(moving), 1, shading->has_thin_glass()});
        std::vector<glm::mat4> transforms;
        for (const Instance& instance : model.instances)
            transforms.push_back(instance.world_from_object);
        lights.emitters.build(*shading, transforms, *textures_);
        traced_ = std::make_unique<TracedScene>(TracedScene{*bvh, *shading, *textures_, lights, options, &openings});
        return *traced_;
    }

    /// `pixels` independent pixels of 64 samples, all along the same ray.
    MeanRadiance look(const glm::vec3& origin, const glm::vec3& direction, int pixels = 256) {
        build();
        Worker worker(*traced_);
        std::vector<es_ray> rays(static_cast<std::size_t>(pixels), make_ray(origin, direction));
        std::vector<std::uint64_t> seeds(rays.size());
        for (std::size_t i = 0; i < seeds.size(); ++i)
            seeds[i] = 0x1234567 + i * 7919;
        constexpr std::uint32_t samples = 64;
        std::vector<float> rgba(rays.size() * 4);
        std::vector<glm::dvec3> pixel_means(rays.size(), glm::dvec3(0));
        for (std::uint32_t s = 0; s < samples; ++s) {
            worker.trace_radiance(rays, seeds, s, rgba);
            for (std::size_t i = 0; i < rays.size(); ++i)
                pixel_means[i] += glm::dvec3(rgba[4 * i], rgba[4 * i + 1], rgba[4 * i + 2]) / double{samples};
        }
        MeanRadiance result;
        double squares = 0;
        for (const glm::dvec3& m : pixel_means) {
            result.mean += m / static_cast<double>(pixels);
            squares += m.y * m.y / pixels;
        }
        const double variance = std::max(0.0, squares - result.mean.y * result.mean.y);
        result.standard_error = std::sqrt(variance / (pixels - 1));
        return result;
    }

    std::unique_ptr<ShadingScene> shading;
    std::unique_ptr<Bvh> bvh;

private:
    std::unique_ptr<Textures> textures_;
    std::unique_ptr<TracedScene> traced_;
};

/// A rectangle in the plane y = 0, facing up, of the given half sides.
inline Mesh floor_mesh(float half_x, float half_z, std::uint32_t material) {
    Mesh m;
    m.positions = {{-half_x, 0, -half_z}, {half_x, 0, -half_z}, {half_x, 0, half_z}, {-half_x, 0, half_z}};
    m.uvs = {{0, 0}, {1, 0}, {1, 1}, {0, 1}};
    m.triangles = {{0, 2, 1}, {0, 3, 2}};
    m.material = material;
    return m;
}

/// A unit sphere of latitude bands, `n` of them; vertices lie on the sphere.
inline Mesh ball_mesh(int n, std::uint32_t material, bool smooth) {
    Mesh m;
    m.material = material;
    for (int i = 0; i <= n; ++i)
        for (int j = 0; j < 2 * n; ++j) {
            const float theta = pi_f * static_cast<float>(i) / static_cast<float>(n);
            const float phi = pi_f * static_cast<float>(j) / static_cast<float>(n);
            m.positions.emplace_back(std::sin(theta) * std::cos(phi), std::cos(theta), std::sin(theta) * std::sin(phi));
        }
    const auto at = [n](int i, int j) { return static_cast<std::uint32_t>(i * 2 * n + j % (2 * n)); };
    for (int i = 0; i < n; ++i)
        for (int j = 0; j < 2 * n; ++j) {
            if (i > 0)
                m.triangles.emplace_back(at(i, j), at(i, j + 1), at(i + 1, j));
            if (i + 1 < n)
                m.triangles.emplace_back(at(i, j + 1), at(i + 1, j + 1), at(i + 1, j));
        }
    if (smooth)
        m.normals = m.positions;
    return m;
}

}  // namespace equistream::embree_host
