#include "bundled.h"
#include "scene_builder.h"

#include <array>

namespace equistream::generate {
namespace {

/// The three surfaces that neither absorb nor, with an index of refraction of 1, mix a coat with their diffuse part.
struct Surfaces {
    std::uint32_t diffuse, mirror, glass;
};

void add_balls(SceneBuilder& scene, const Surfaces& surfaces) {
    const Shape ball = sphere(0.5f, 96, 48);
    const std::uint32_t diffuse = scene.mesh("diffuse ball", ball, surfaces.diffuse);
    const std::uint32_t mirror = scene.mesh("mirror ball", ball, surfaces.mirror);
    const std::uint32_t clear = scene.mesh("glass ball", ball, surfaces.glass);
    scene.object("diffuse", {diffuse}, moved({-1.3f, 0, -2.5f}));
    scene.object("mirror", {mirror}, moved({0, 0, -2.5f}));
    scene.object("glass", {clear}, moved({1.3f, 0, -2.5f}));
    // Behind and beside the camera, so that balls see one another and light bounces between unlike surfaces.
    scene.object("diffuse behind", {diffuse}, moved({0.6f, 0.2f, 1.5f}));
    scene.object("mirror behind", {mirror}, moved({-0.6f, -0.2f, 1.5f}));
    scene.object("glass behind", {clear}, moved({0, 1.1f, 1.4f}));
}

}  // namespace

/// Open: radiance 1 from everywhere, surfaces that lose none: 1 everywhere, by conservation of energy.
/// Closed: every wall and diffuse ball emits 1/2 and reflects 1/2, so L = 1/2 + L/2 = 1; mirrors and glass pass it on.
GeneratedScene make_furnace(const GeneratorValues& values) {
    const bool closed = values.word("kind", furnace_kinds) == "closed";
    SceneBuilder scene;
    Material diffuse = matt("diffuse", glm::vec3(closed ? 0.5f : 1.0f), 1);
    diffuse.index_of_refraction = 1;
    diffuse.emission = glm::vec3(closed ? 0.5f : 0.0f);
    const Surfaces surfaces{scene.material(diffuse), scene.material(metal("mirror", glm::vec3(1), 0)),
                            scene.material(glass("glass"))};
    add_balls(scene, surfaces);
    if (closed)
        scene.add("walls", inside_out(box({8, 6, 8})), surfaces.diffuse);
    GeneratedScene result;
    result.model = scene.finish();
    result.description.sky_radiance = glm::dvec3(closed ? 0 : 1);
    result.description.camera_path = PosePath({{0, {}}}, "furnace");
    return result;
}

}  // namespace equistream::generate
