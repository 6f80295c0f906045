#include "bundled.h"
#include "glowing_room.h"
#include "noise.h"

#include <array>

namespace equistream::generate {
namespace {

constexpr std::array<glm::vec3, 6> colours{{{0.85f, 0.15f, 0.12f},
                                            {0.12f, 0.65f, 0.2f},
                                            {0.12f, 0.25f, 0.85f},
                                            {0.92f, 0.8f, 0.1f},
                                            {0.75f, 0.92f, 0.95f},
                                            {0.45f, 0.12f, 0.5f}}};
constexpr std::array<char, 6> letters{'F', 'R', 'B', 'L', 'U', 'D'};

struct Patch {
    glm::vec2 centre, half;
    glm::vec3 colour;
};

/// Patches of unlike colours, sizes and places: no side has a symmetry, no two are alike.
std::vector<Patch> scattered_patches(Side side) {
    Random random(100 + static_cast<std::uint64_t>(side));
    std::vector<Patch> patches;
    for (int i = 0; i < 9; ++i)
        patches.push_back({{random.uniform(), random.uniform()},
                           {random.between(0.03f, 0.12f), random.between(0.03f, 0.12f)},
                           {random.uniform(), random.uniform(), random.uniform()}});
    return patches;
}

ByteImage paint_side(Side side) {
    const std::vector<Patch> patches = scattered_patches(side);
    return paint(512, 512, 3, [&](glm::vec2 at) {
        constexpr float soft = 0.006f;
        glm::vec3 colour = colours[side] * (0.55f + 0.3f * (1 - at.y) + 0.15f * at.x);
        for (const Patch& patch : patches) {
            const glm::vec2 outside = glm::abs(at - patch.centre) - patch.half;
            colour = glm::mix(colour, patch.colour, coverage(std::max(outside.x, outside.y), soft));
        }
        const float height = 0.5f;
        const glm::vec2 in_letter = (at - glm::vec2(0.36f, 0.22f)) / height;
        const float edge = height * distance_to_text({&letters[side], 1}, in_letter) - 0.03f;
        colour = glm::mix(colour, glm::vec3(0.03f), coverage(edge - 0.012f, soft));
        colour = glm::mix(colour, glm::vec3(0.97f), coverage(edge, soft));
        // An arrow to the right along the bottom.
        const float arrow = std::min({distance_to_segment(at, {0.25f, 0.87f}, {0.75f, 0.87f}),
                                      distance_to_segment(at, {0.75f, 0.87f}, {0.66f, 0.81f}),
                                      distance_to_segment(at, {0.75f, 0.87f}, {0.66f, 0.93f})});
        return glm::vec4(glm::mix(colour, glm::vec3(0.03f), coverage(arrow - 0.015f, soft)), 1);
    });
}

}  // namespace

GeneratedScene make_orientation(const GeneratorValues&) {
    SceneBuilder scene;
    add_glowing_room(scene, {6, 5, 7}, paint_side);
    GeneratedScene result;
    result.model = scene.finish();
    result.description.camera_path = PosePath({{0, {{0.4, -0.3, 0.5}, {1, 0, 0, 0}}}}, "orientation");
    return result;
}

}  // namespace equistream::generate
