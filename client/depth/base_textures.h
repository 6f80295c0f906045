#pragma once
/// Base colour textures as a client wants them: small mip chains in memory, filled when first asked for. A coarser
/// level's texels have the mean light of the finer one's.
#include <scenes/library/model.h>

#include <array>
#include <memory>
#include <mutex>
#include <span>
#include <vector>

namespace equistream {

class BaseTextures {
public:
    /// Longest side that is kept of an image: what a gap shows is small.
    static constexpr int longest_side = 1024;

    /// Coordinates beyond this say nothing about a texel any more, and would overflow an int.
    static constexpr float farthest_coordinate = 1e5f;

    struct Level {
        int width = 0, height = 0;
        std::vector<std::uint8_t> rgb;  ///< sRGB
    };

    /// `model` is borrowed.
    explicit BaseTextures(const SceneModel& model);
    ~BaseTextures();

    /// Makes ready what `lookup` would make the first time. Any number of threads.
    void decode(std::uint32_t texture) const;
    /// Linear colour at glTF texture coordinates, bilinear, from the level whose texels are about `footprint` wide (in
    /// texture coordinates). White where the image cannot be decoded. Any number of threads.
    glm::vec3 lookup(std::uint32_t texture, glm::vec2 uv, float footprint) const;

private:
    struct Chain {
        std::once_flag once;
        std::vector<Level> levels;  ///< finest first
    };
    void fill(std::uint32_t texture) const;
    glm::vec3 texel(const Texture& texture, const Level& level, int x, int y) const;

    const SceneModel& model_;
    std::unique_ptr<Chain[]> chains_;
    std::array<float, 256> to_linear_{};
};

// What base colours are taken to say of surfaces, and numbers of how their textures are looked up.

/// Smaller triangles' textures are looked up as if they were so large.
inline constexpr float min_triangle_m2 = 1e-12f;
/// Of the angle at which a surface is seen: flatter ones' textures are looked up as if they were not.
inline constexpr float min_seen_cosine = 1e-3f;

/// False of what shines by itself, mirrors or is glass, so that its base colour says little.
inline bool is_matte(const Material& material) {
    const bool emits = glm::any(glm::greaterThan(material.emission, glm::vec3(0)));
    const bool mirrors = material.metallic > 0.5f && material.roughness < mirror_roughness;
    return !emits && !mirrors && !(material.transmission > 0.5f);
}

}  // namespace equistream
