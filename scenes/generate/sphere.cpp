#include "bundled.h"
#include "scene_builder.h"

#include <cmath>
#include <numbers>

namespace equistream::generate {

/// A ring of segments and rings such that no triangle's circumcircle spans an angle above 2 pi/n seen from the centre:
/// cells of 2 pi / (sqrt(2) n) on both sides have that diagonal. Every facet then lies beyond R cos(pi/n).
GeneratedScene make_sphere(const GeneratorValues& values) {
    const auto radius = static_cast<float>(values.number("radius", 0.01, 1e6));
    const int n = values.count("n", 4, 2048);
    const double offset = values.number("offset", 0, 0.99);
    const int segments = static_cast<int>(std::ceil(std::numbers::sqrt2 * n));
    SceneBuilder scene;
    const auto paintwork = scene.texture("stripes", paint(512, 256, 3, [](glm::vec2 at) {
                                             const bool odd =
                                                 (static_cast<int>(at.x * 24) + static_cast<int>(at.y * 12)) % 2;
                                             return glm::vec4(at.x, odd ? 0.75f : 0.35f, 1 - at.y, 1);
                                         }));
    scene.add("sphere", inside_out(sphere(radius, segments, (segments + 1) / 2)),
              scene.material(glowing("inside", glm::vec3(1), paintwork)));
    GeneratedScene result;
    result.model = scene.finish();
    result.description.camera_path = PosePath({{0, {{offset * radius, 0, 0}, {1, 0, 0, 0}}}}, "sphere");
    return result;
}

GeneratedScene make_empty(const GeneratorValues&) {
    GeneratedScene result;
    result.model.objects.push_back({"nothing", -1});
    result.description.camera_path = PosePath({{0, {}}}, "empty");
    return result;
}

}  // namespace equistream::generate
