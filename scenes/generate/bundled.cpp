#include "bundled.h"

#include "paint.h"
#include "scene_builder.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>

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

namespace {

constexpr int keys_a_second = 30;

/// Smooth in every direction, so that sampling between pixels is accurate; no two places alike.
ByteImage clouds(std::uint32_t seed, glm::vec3 tint) {
    return paint(512, 512, 3, [&](glm::vec2 at) {
        glm::vec3 colour;
        for (int c = 0; c < 3; ++c)
            colour[c] = 0.5f + 0.35f * turbulence(8.0f * at, 8, 3, seed + 10 * static_cast<std::uint32_t>(c));
        return glm::vec4(glm::mix(tint, colour, 0.7f), 1);
    });
}

/// From `from` to `to` in one second, turning about `axis`, and back in the next, as long as told.
class Glide {
public:
    explicit Glide(int seconds) : seconds_(seconds) {}

    PosePath operator()(glm::dvec3 from, glm::dvec3 to, glm::dvec3 axis, double turn_rad) const {
        std::vector<PosePath::Key> keys;
        for (int i = 0; i <= keys_a_second * seconds_; ++i) {
            const int on = i % (2 * keys_a_second), step = std::min(on, 2 * keys_a_second - on);
            const double t = static_cast<double>(step) / keys_a_second;
            keys.push_back({i / static_cast<double>(keys_a_second),
                            {glm::mix(from, to, t), glm::angleAxis(turn_rad * t, glm::normalize(axis))}});
        }
        return PosePath(std::move(keys), "motion");
    }

private:
    int seconds_;
};

std::uint32_t cloudy(SceneBuilder& scene, const std::string& name, std::uint32_t seed, glm::vec3 tint) {
    return scene.material(glowing(name, glm::vec3(1), scene.texture(name, clouds(seed, tint), Encoding::png)));
}

}  // namespace

/// Light only, so frames are free of noise and shading. The ball crosses the seam (straight behind), the block passes
/// over the upper pole.
GeneratedScene make_motion(const GeneratorValues& values) {
    const Glide glide(values.count("seconds", 1, 600));
    SceneBuilder scene;
    add_glowing_room(scene, {6, 5, 6}, [](Side side) {
        return clouds(1000 + 100 * static_cast<std::uint32_t>(side),
                      {side % 2 ? 0.8f : 0.2f, side % 3 ? 0.3f : 0.7f, side < 3 ? 0.6f : 0.3f});
    });
    const auto ball = scene.mesh("ball", sphere(0.35f, 96, 48), cloudy(scene, "ball", 31, {0.9f, 0.2f, 0.1f}));
    const auto block =
        scene.mesh("block", bevelled_box({0.9f, 0.3f, 0.6f}, 0.03f), cloudy(scene, "block", 57, {0.1f, 0.8f, 0.3f}));
    const PosePath ball_path = glide({0.8, -0.2, 1.9}, {-0.8, 0.1, 1.7}, {0, 0, 1}, 1.2);
    const PosePath block_path = glide({-0.5, 1.6, 0.3}, {0.5, 1.7, -0.2}, {0.2, 1, 0}, 0.8);
    scene.object("ball", {ball}, moved(glm::vec3(ball_path.at(0).position_m)));
    scene.object("block", {block}, moved(glm::vec3(block_path.at(0).position_m)));
    GeneratedScene result;
    result.model = scene.finish();
    result.description.camera_path = glide({-0.3, 0, 0.2}, {0.4, 0.15, -0.3}, {0.1, 1, 0}, -0.6);
    result.description.moving = {{"ball", ball_path}, {"block", block_path}};
    return result;
}

namespace {

constexpr glm::vec3 colours[] = {{0.85f, 0.15f, 0.12f}, {0.12f, 0.65f, 0.2f},  {0.12f, 0.25f, 0.85f},
                                 {0.92f, 0.8f, 0.1f},   {0.75f, 0.92f, 0.95f}, {0.45f, 0.12f, 0.5f}};
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
