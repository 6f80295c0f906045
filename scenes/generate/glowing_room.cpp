#include "glowing_room.h"

namespace equistream::generate {

void add_glowing_room(SceneBuilder& scene, glm::vec3 size, const std::function<ByteImage(Side)>& paint_side) {
    struct Axes {
        glm::vec3 right, up;
    };
    constexpr std::array<Axes, 6> axes{{{{1, 0, 0}, {0, 1, 0}},
                                        {{0, 0, 1}, {0, 1, 0}},
                                        {{-1, 0, 0}, {0, 1, 0}},
                                        {{0, 0, -1}, {0, 1, 0}},
                                        {{1, 0, 0}, {0, 0, 1}},
                                        {{1, 0, 0}, {0, 0, -1}}}};
    for (int i = 0; i < 6; ++i) {
        const Axes& a = axes[i];
        const glm::vec3 inwards = glm::cross(a.right, a.up);
        Shape wall = card(1, 1);
        for (std::size_t k = 0; k < wall.positions.size(); ++k) {
            const glm::vec3 p = wall.positions[k];
            wall.positions[k] = size * (p.x * a.right + p.y * a.up - 0.5f * inwards);
            wall.normals[k] = inwards;
        }
        const std::string name(side_names[i]);
        const auto texture = scene.texture(name, paint_side(static_cast<Side>(i)), Encoding::png, Wrap::clamp);
        scene.add(name, std::move(wall), scene.material(glowing(name, glm::vec3(1), texture)));
    }
}

}  // namespace equistream::generate
