#include "bundled.h"
#include "scene_builder.h"

#include <algorithm>
#include <cmath>

namespace equistream::generate {
namespace {

/// Reflects as Lambert says, without a coat: an index of refraction of 1.
Material plain(const std::string& name, glm::vec3 linear_colour, std::uint32_t texture = no_index) {
    Material material = matt(name, linear_colour, 1);
    material.index_of_refraction = 1;
    material.base_colour_texture = texture;
    return material;
}

/// Light that reflects nothing.
Material lamp(const std::string& name, glm::vec3 radiance, std::uint32_t texture = no_index) {
    Material material = plain(name, glm::vec3(0));
    material.emission = radiance;
    material.emission_texture = texture;
    return material;
}

/// No two of its quarters alike, with texels that are larger than pixels.
ByteImage chart(int side) {
    return paint(side, side, 3, [](glm::vec2 at) {
        const bool right = at.x > 0.5f, low = at.y > 0.5f;
        const glm::vec3 corner = right ? (low ? glm::vec3(0.9f, 0.8f, 0.2f) : glm::vec3(0.2f, 0.7f, 0.3f))
                                       : (low ? glm::vec3(0.2f, 0.3f, 0.9f) : glm::vec3(0.9f, 0.2f, 0.15f));
        const bool odd = (static_cast<int>(at.x * 8) + static_cast<int>(at.y * 8)) % 2;
        return glm::vec4(corner * (odd ? 1.0f : 0.6f), 1);
    });
}

/// Strokes of an F that is there, around it nothing.
ByteImage stencil() {
    return paint(96, 128, 4, [](glm::vec2 at) {
        const glm::vec2 p = (at - glm::vec2(0.25f, 0.15f)) / 0.7f;
        return glm::vec4(0.75f, 0.4f, 0.2f + 0.5f * at.y, distance_to_text("F", p) < 0.11f ? 1 : 0);
    });
}

/// A block with a slope: it differs from its mirror image.
Shape wedge() {
    Shape shape = box({0.8f, 0.5f, 0.5f});
    for (std::size_t i = 0; i < shape.positions.size(); ++i)
        if (shape.positions[i].x > 0)
            shape.positions[i].y *= 0.4f;
    shape.normals.clear();
    return shape;
}

glm::mat4 upright(glm::vec3 at, float turn_rad) {
    return moved(at) * turned_y(turn_rad);
}

glm::mat4 facing_down(glm::vec3 at) {
    return moved(at) * glm::rotate(glm::mat4(1), 1.5707963f, glm::vec3(1, 0, 0));
}

void add_room(SceneBuilder& scene) {
    const auto tiles = scene.texture("tiles", chart(32), Encoding::png);
    const auto mirrored = scene.texture("paper", chart(16), Encoding::png, Wrap::mirror);
    Shape floor = card(8, 8), wall = card(8, 4);
    for (glm::vec2& uv : floor.uvs)
        uv *= 1.5f;
    for (glm::vec2& uv : wall.uvs)
        uv *= glm::vec2(3, 2);
    const auto ground = scene.mesh("floor", floor, scene.material(plain("tiles", {0.9f, 0.9f, 0.9f}, tiles)));
    const auto paper = scene.mesh("wall", wall, scene.material(plain("paper", glm::vec3(1), mirrored)));
    scene.object("floor", {ground}, moved({0, -1.5f, 0}) * glm::rotate(glm::mat4(1), -1.5707963f, glm::vec3(1, 0, 0)));
    scene.object("wall ahead", {paper}, upright({0, 0.5f, -4}, 0));
    scene.object("wall behind", {paper}, upright({0, 0.5f, 4}, 3.1415927f));
}

void add_lights(SceneBuilder& scene) {
    const auto ceiling = scene.mesh("lamp", card(2.5f, 2.5f), scene.material(lamp("lamp", {5, 4.6f, 4})));
    scene.object("lamp", {ceiling}, facing_down({0.5f, 2.5f, 0.2f}));
    const auto picture = scene.texture("picture", chart(32), Encoding::png, Wrap::clamp);
    const auto screen = scene.mesh("screen", card(1.2f, 1.2f), scene.material(lamp("screen", {2, 2, 2}, picture)));
    scene.object("screen", {screen}, upright({-2.6f, 0, -1.4f}, 0.9f));
}

void add_things(SceneBuilder& scene) {
    const auto ball = scene.mesh("ball", sphere(0.5f, 256, 128), scene.material(plain("red", {0.7f, 0.1f, 0.08f})));
    scene.object("ball", {ball}, moved({-0.9f, -1, -2.2f}));
    const auto mirror = scene.mesh("mirror", card(1.4f, 2), scene.material(metal("mirror", glm::vec3(1), 0)));
    scene.object("mirror", {mirror}, upright({1.9f, -0.3f, -2.4f}, -0.6f));
    Material tinted = glass("tinted glass");
    tinted.base_colour = {0.5f, 0.8f, 0.95f};
    const auto pane = scene.mesh("pane", card(1, 1.6f), scene.material(tinted));
    scene.object("pane", {pane}, upright({0.3f, -0.5f, -1.6f}, 0.3f));
    const auto window = scene.mesh("window", card(1.6f, 1.6f), scene.material(glass("clear glass")));
    scene.object("window", {window}, upright({-2.2f, -0.2f, 0.4f}, 0.5f));  // seen aslant, lamp and tiles in it
    const auto cut = scene.masked_material("stencil", stencil(), 1);
    scene.at(cut).index_of_refraction = 1;
    const auto letter = scene.mesh("stencil", card(1.2f, 1.6f), cut);
    scene.object("stencil", {letter}, upright({2.2f, -0.4f, 1.2f}, -1.9f));
    const auto block = scene.mesh("wedge", wedge(), scene.material(plain("blue", {0.15f, 0.25f, 0.6f})));
    scene.object("wedge", {block}, upright({-1.6f, -1.25f, 1.5f}, 0.4f));
    scene.object("mirrored wedge", {block},
                 upright({-0.3f, -1.25f, 2.2f}, -0.5f) * glm::scale(glm::mat4(1), glm::vec3(-1, 1, 1)));
    scene.object("moving wedge", {block}, moved({1, -1.25f, 1.5f}));
}

PosePath::Key key(double time_s, glm::dvec3 position_m, double turn_rad) {
    return {time_s, {position_m, glm::angleAxis(turn_rad, glm::dvec3(0, 1, 0))}};
}

}  // namespace

/// Only what every renderer means the same by: Lambert, perfect mirrors, panes of glass, textures, masks, lamps, a
/// sky.
GeneratedScene make_materials(const GeneratorValues&) {
    SceneBuilder scene;
    add_room(scene);
    add_lights(scene);
    add_things(scene);
    GeneratedScene result;
    result.model = scene.finish();
    result.description.sky_radiance = {0.3, 0.4, 0.6};
    result.description.camera_path = PosePath({key(0, {0, 0, 0}, 0), key(1, {0.6, 0.1, -0.3}, 0.4)}, "materials");
    result.description.moving = {
        {"moving wedge", PosePath({key(0, {1, -1.25, 1.5}, 0), key(1, {0.2, -1.1, 1.4}, 1)}, "materials")}};
    return result;
}

}  // namespace equistream::generate
