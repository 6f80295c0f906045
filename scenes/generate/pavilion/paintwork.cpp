#include "paintwork.h"

namespace equistream::generate::pavilion {
namespace {

Material plain(const std::string& name, glm::vec3 display_colour, float roughness = 0.9f) {
    return matt(name, linear_from_srgb(display_colour), roughness);
}

Material seen_from_both_sides(Material material) {
    material.double_sided = true;
    return material;
}

void add_stone_and_wood(SceneBuilder& scene, Paintwork& p) {
    p.tiles = scene.material(textured("marble tiles", scene.texture("tiles", paint_tiles()), 0.22f));
    p.medallion = scene.material(
        textured("medallion", scene.texture("medallion", paint_medallion(), Encoding::jpeg, Wrap::clamp), 0.22f));
    p.dark_marble = scene.material(textured("dark marble", scene.texture("dark marble", paint_dark_marble()), 0.2f));
    p.limestone = scene.material(textured("limestone", scene.texture("limestone", paint_limestone()), 0.8f));
    p.wood = scene.material(textured("wood", scene.texture("wood", paint_wood()), 0.55f));
    p.paving = scene.material(textured("paving", scene.texture("paving", paint_paving()), 0.85f));
    p.terracotta = scene.material(plain("terracotta", {0.72f, 0.42f, 0.29f}));
    p.soil = scene.material(plain("soil", {0.2f, 0.14f, 0.1f}));
}

void add_metal_and_glass(SceneBuilder& scene, Paintwork& p) {
    p.iron = scene.material(plain("wrought iron", {0.13f, 0.14f, 0.15f}, 0.45f));
    p.brass = scene.material(metal("brass", {0.88f, 0.7f, 0.36f}, 0.28f));
    p.copper = scene.material(metal("copper", {0.93f, 0.6f, 0.46f}, 0.24f));
    p.mirror = scene.material(metal("mirror", {0.95f, 0.95f, 0.95f}, 0));
    Material bell_glass = glass("tinted glass");  // thin-walled: without a volume glTF's glass does not refract
    bell_glass.base_colour = {0.8f, 0.93f, 0.9f};
    p.tinted_glass = scene.material(bell_glass);
    p.lamp = scene.material(glowing("lamp", {14, 7.5f, 2.4f}));
}

void add_things(SceneBuilder& scene, Paintwork& p) {
    p.china = scene.material(plain("china", {0.86f, 0.88f, 0.9f}, 0.15f));
    p.tea = scene.material(plain("tea", {0.42f, 0.2f, 0.08f}, 0.05f));
    p.orange = scene.material(plain("orange", {0.93f, 0.52f, 0.1f}, 0.4f));
    p.sail = scene.material(seen_from_both_sides(plain("sail", {0.93f, 0.88f, 0.78f})));
    p.cloud = scene.material(plain("cloud", {0.97f, 0.97f, 0.97f}, 1));
    p.book = scene.material(plain("book", {0.16f, 0.29f, 0.5f}, 0.5f));
    p.beach_ball =
        scene.material(textured("beach ball", scene.texture("beach ball", paint_beach_ball(), Encoding::png), 0.35f));
    for (int i = 0; i < 4; ++i) {
        const std::string name = "banner " + std::to_string(i + 1);
        const auto cloth = scene.texture(name, paint_banner(i), Encoding::png, Wrap::clamp);
        p.banners[i] = scene.material(seen_from_both_sides(textured(name, cloth, 1)));
    }
    p.sign_north = scene.material(textured(
        "sign north", scene.texture("sign north", paint_sign("TOWER", false), Encoding::png, Wrap::clamp), 0.6f));
    p.sign_east = scene.material(
        textured("sign east", scene.texture("sign east", paint_sign("LAKE", true), Encoding::png, Wrap::clamp), 0.6f));
}

void add_nature(SceneBuilder& scene, Paintwork& p) {
    p.lawn = scene.material(textured("lawn", scene.texture("lawn", paint_lawn()), 1));
    p.far_land = scene.material(textured("far land", scene.texture("far land", paint_far_land()), 1));
    p.water = scene.material(plain("water", {0.1f, 0.2f, 0.22f}, 0.03f));
    p.bark = scene.material(textured("bark", scene.texture("bark", paint_bark()), 1));
    p.blade_green = scene.material(seen_from_both_sides(plain("grass blades", {0.38f, 0.5f, 0.16f})));
    p.blade_straw = scene.material(seen_from_both_sides(plain("dry blades", {0.56f, 0.55f, 0.27f})));
    p.petal_red = scene.material(seen_from_both_sides(plain("red petals", {0.8f, 0.13f, 0.12f})));
    p.petal_white = scene.material(seen_from_both_sides(plain("white petals", {0.92f, 0.9f, 0.84f})));
    p.petal_blue = scene.material(seen_from_both_sides(plain("blue petals", {0.36f, 0.34f, 0.78f})));
    p.twig_leaf = scene.masked_material("twigs", paint_twig(), 0.7f);
    p.ivy_leaf = scene.masked_material("ivy", paint_ivy_leaf(), 0.5f);
    p.long_leaf = scene.masked_material("long leaves", paint_long_leaf(), 0.45f);
    p.cypress_leaf = scene.masked_material("cypress", paint_cypress(), 0.9f);
}

}  // namespace

Paintwork paint_all(SceneBuilder& scene) {
    Paintwork p{};
    add_stone_and_wood(scene, p);
    add_metal_and_glass(scene, p);
    add_things(scene, p);
    add_nature(scene, p);
    return p;
}

}  // namespace equistream::generate::pavilion
