/// Models, and what clients need of them.
#include "target.h"

#include <client/model/client_model.h>
#include <scenes/library/model.h>
#include <scenes/library/scene.h>
#include <tests/unit/scenes/gltf_builder.h>
#include <tests/unit/scenes/temporary_folder.h>

#include <algorithm>
#include <array>

namespace equistream::fuzz {

namespace {

/// What holds of every model that load_model gives.
void check_promises(const Mesh& mesh, const SceneModel& model) {
    require(mesh.material < model.materials.size(), "a mesh's material is there");
    require(mesh.normals.empty() || mesh.normals.size() == mesh.positions.size(), "one normal a position, or none");
    require(mesh.uvs.empty() || mesh.uvs.size() == mesh.positions.size(), "one texture coordinate a position, or none");
    for (const glm::uvec3& corner : mesh.triangles)
        require(std::max({corner.x, corner.y, corner.z}) < mesh.positions.size(), "a triangle's corners are there");
}

void check_promises(const SceneModel& model) {
    require(model.triangle_count() > 0, "there is a triangle");
    for (const Mesh& mesh : model.meshes)
        check_promises(mesh, model);
    for (const Instance& instance : model.instances)
        require(instance.mesh < model.meshes.size() && instance.object < model.objects.size(),
                "what an instance places is there");
    for (const AlphaMask& mask : model.alpha_masks)
        require(mask.opaque.size() == static_cast<std::size_t>(mask.width) * static_cast<std::size_t>(mask.height),
                "a mask has its texels");
}

}  // namespace

// GLB, or glTF with its buffer in a data URI.

namespace {

void take_model(Bytes bytes) {
    check_promises(load_model(scratch_file("model.gltf", bytes)));
}

/// A triangle with normals, texture coordinates, a masked material, a sparse position and a placement by matrix.
test::GltfBuilder rich() {
    using test::GltfBuilder;
    GltfBuilder builder;
    const int positions = builder.accessor<float>({0, 0, 0, 1, 0, 0, 0, 1, 0}, test::gl_float, "VEC3", 3);
    builder.json["accessors"][0]["sparse"] = {
        {"count", 1},
        {"indices",
         {{"bufferView", builder.view(GltfBuilder::bytes_of<std::uint16_t>({2}))},
          {"componentType", test::gl_unsigned_short}}},
        {"values", {{"bufferView", builder.view(GltfBuilder::bytes_of<float>({0, 2, 0}))}}}};
    const int normals =
        builder.accessor<std::int8_t>({0, 0, 127, 0, 0, 0, 127, 0, 0, 0, 127, 0}, test::gl_byte, "VEC3", 3, 4);
    builder.json["accessors"].back()["normalized"] = true;
    const int uvs = builder.accessor<float>({0, 0, 1, 0, 0, 1}, test::gl_float, "VEC2", 3);
    const int indices = builder.accessor<std::uint32_t>({0, 1, 2}, test::gl_unsigned_int, "SCALAR", 3);
    const std::string png = test::png_rgba(2, 1, {255, 0, 0, 255, 0, 255, 0, 0});
    builder.json["images"] = {{{"bufferView", builder.view(png)}, {"mimeType", "image/png"}}};
    builder.json["textures"] = {{{"source", 0}}};
    builder.json["materials"] = {{{"alphaMode", "MASK"},
                                  {"doubleSided", true},
                                  {"pbrMetallicRoughness", {{"baseColorTexture", {{"index", 0}}}}}}};
    const int mesh = builder.mesh({{"POSITION", positions}, {"NORMAL", normals}, {"TEXCOORD_0", uvs}}, indices, 0);
    builder.json["extensionsUsed"] = {"KHR_mesh_quantization"};
    builder.node({{"name", "leaf"}, {"mesh", mesh}, {"matrix", {2, 0, 0, 0, 0, 2, 0, 0, 0, 0, 2, 0, 1, 2, 3, 1}}});
    builder.node({{"name", "twig"}, {"children", {0}}, {"rotation", {0, 0.6, 0, 0.8}}, {"scale", {1, -1, 1}}});
    builder.json["scenes"] = {{{"nodes", {1}}}};
    builder.json["scene"] = 0;
    return builder;
}

std::string in_base64(std::string_view bytes) {
    constexpr std::string_view digits = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
    std::string text;
    for (std::size_t at = 0; at < bytes.size(); at += 3) {
        unsigned three = 0;
        for (std::size_t i = 0; i < 3; ++i)
            three = three << 8 | (at + i < bytes.size() ? std::uint8_t(bytes[at + i]) : 0);
        for (int shift = 18; shift >= 0; shift -= 6)
            text += digits[three >> shift & 63];
    }
    const std::size_t left_over = (3 - bytes.size() % 3) % 3;
    return text.replace(text.size() - left_over, left_over, left_over, '=');
}

std::string in_one_text(const test::GltfBuilder& builder) {
    return builder.gltf("data:application/octet-stream;base64," + in_base64(builder.buffer));
}

/// Lines, so that one can be taken away, and every kind of indices, texture coordinates and material.
std::string kinds() {
    using test::GltfBuilder;
    GltfBuilder builder;
    const int positions = builder.accessor<float>({0, 0, 0, 1, 0, 0, 0, 1, 0, 1, 1, 0}, test::gl_float, "VEC3", 4);
    const int bytes = builder.accessor<std::uint8_t>({0, 1, 2, 3}, test::gl_unsigned_byte, "SCALAR", 4);
    const int shorts =
        builder.accessor<std::int16_t>({0, 0, 0, 0, 9, 9, 9, 0, 9, 0, 0, 0}, test::gl_short, "VEC3", 3, 8);
    const int uvs =
        builder.accessor<std::uint16_t>({0, 0, 65535, 0, 0, 65535, 1, 1}, test::gl_unsigned_short, "VEC2", 4);
    builder.json["accessors"].back()["normalized"] = true;
    const std::string png = test::png_rgba(1, 1, {255, 0, 0, 9});
    builder.json["images"] = {{{"uri", "data:image/png;base64," + in_base64(png)}}};
    builder.json["samplers"] = {{{"wrapS", 33071}, {"wrapT", 33648}, {"magFilter", 9728}}};
    builder.json["textures"] = {{{"source", 0}, {"sampler", 0}}, {{"source", 0}}};
    builder.json["materials"] = {
        {{"name", "glass"},
         {"alphaMode", "BLEND"},
         {"emissiveFactor", {1, 0.5, 0}},
         {"extensions",
          {{"KHR_materials_transmission", {{"transmissionFactor", 1}}},
           {"KHR_materials_ior", {{"ior", 1.4}}},
           {"KHR_materials_emissive_strength", {{"emissiveStrength", 2}}},
           {"KHR_materials_specular", {{"specularFactor", 0.5}, {"specularColorFactor", {1, 1, 0.5}}}}}},
         {"pbrMetallicRoughness",
          {{"baseColorFactor", {1, 1, 1, 0.5}},
           {"metallicFactor", 0},
           {"roughnessFactor", 0.1},
           {"metallicRoughnessTexture", {{"index", 0}}}}}},
        {{"alphaMode", "MASK"},
         {"alphaCutoff", 0.3},
         {"normalTexture", {{"index", 0}, {"scale", 0.5}}},
         {"pbrMetallicRoughness",
          {{"baseColorTexture",
            {{"index", 0},
             {"extensions",
              {{"KHR_texture_transform", {{"offset", {0.5, 0}}, {"scale", {2, 2}}, {"rotation", 1}}}}}}}}}}};
    builder.json["extensionsUsed"] = {"KHR_materials_transmission", "KHR_texture_transform", "KHR_mesh_quantization"};
    const auto part = [&](int mesh) { builder.node({{"mesh", mesh}, {"translation", {0, mesh, 0}}}); };
    part(builder.mesh({{"POSITION", positions}, {"TEXCOORD_0", uvs}}, bytes, 1, 5));
    part(builder.mesh({{"POSITION", positions}}, bytes, 0, 6));
    part(builder.mesh({{"POSITION", shorts}}));
    part(builder.mesh({{"POSITION", positions}}, bytes, 0, 1));
    return test::Json::parse(in_one_text(builder)).dump(0);
}

constexpr std::array<std::string_view, 32> model_words = {
    "\"matrix\": [1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1],",
    "\"rotation\": [1, 0, 0, 0],",
    "\"skin\": 0,",
    "\"byteStride\": 1,",
    "\"byteOffset\": 1,",
    "\"normalized\": true,",
    "\"sparse\": {\"count\": 1},",
    "\"children\": [0],",
    "\"mesh\": 0,",
    "\"mode\": 0,",
    "\"indices\": 9,",
    "\"uri\": \"gone.bin\",",
    "\"uri\": \"data:,\",",
    "\"data:image/png;base64,AAAA\"",
    "\"data:application/octet-stream;base64,A=\"",
    "\"VEC3\"",
    "\"VEC2\"",
    "\"SCALAR\"",
    "\"MAT4\"",
    "5120",
    "5121",
    "5122",
    "5123",
    "5125",
    "5126",
    "\"OPAQUE\"",
    "\"MASK\"",
    "\"1.0\"",
    "33648",
    "\"extensionsRequired\": [\"X_none\"],",
    "\"scene\": 7,",
    "1073741824"};

void damage_model(std::vector<std::uint8_t>& bytes, std::mt19937& random) {
    damage_text(model_words, bytes, random);
}

Seeds model_seeds() {
    const test::GltfBuilder triangle = test::GltfBuilder::triangle();
    return {bytes_of(triangle.glb()), bytes_of(rich().glb()), bytes_of(in_one_text(rich())), bytes_of(kinds())};
}

}  // namespace

const Target model_target{"model", take_model, model_seeds, 3000, damage_model};

// An OBJ that is its own MTL: each reader passes over the other's statements.

namespace {

constexpr std::string_view seed = R"(mtllib model.mtl
newmtl leaf
Kd 0.588 0.588 0.588
Ks 0.1 0.1 0.1
Ns 10
d 0.5
Tr 0.5
illum 4
Tf 1 0.5 1
Ke 1 2 3
map_Kd -s 2 2 1 -clamp on gone.tga
map_d gone.tga
newmtl twig
map_Kd leaf.png
map_d grey.png
map_Ke -clamp on leaf.png
newmtl bark
Kd 0.2 0.3 0.4
map_Kd leaf.png
d 0
Tr 0
v 0 0 0
v 1 0 0
v 1 1 0 \
v 0 1 0
v 0.5 0.2 0
vn 0 0 1
vt 0.5 0.25
o thing
g a b
usemtl leaf
s 1
f 1/1/1 2//1 3
f -4 -3 -2 -1
s off
usemtl twig
f 1/1 2/1 3/1
usemtl bark
f 1/1 2/1 3/1
usemtl none
f 1 2 3 4 1
)";

void take_obj(Bytes bytes) {
    static const std::filesystem::path leaf =
        scratch_file("leaf.png", bytes_of(test::png_rgba(2, 1, {255, 0, 0, 255, 0, 255, 0, 0})));
    static const std::filesystem::path grey =
        scratch_file("grey.png", bytes_of(test::png_rgba(2, 1, {255, 255, 255, 255, 0, 0, 0, 255})));
    scratch_file("model.mtl", bytes);
    check_promises(load_model(scratch_file("model.obj", bytes)));
}

constexpr std::array<std::string_view, 26> obj_words = {
    "vn 1 0 0\n",  "vt 0 1\n",      "v 1 2\n", "f 1 2\n",    "f 1 1 1\n",       "f 1//9 2//9 3//9\n", "f 1/9 2/9 3/9\n",
    "l 1 2\n",     "p 1\n",         "g\n",     "usemtl\n",   "mtllib\n",        "mtllib gone\n",      "newmtl\n",
    "map_Kd\n",    "map_Kd -o 1\n", "Kd\n",    "Kd xyz 1\n", "Kd spectral x\n", "illum 11\n",         "d -halo 1\n",
    "-9999999999", "9999999999",    "\\\n",    "#",          "-clamp"};

void damage_obj(std::vector<std::uint8_t>& bytes, std::mt19937& random) {
    damage_text(obj_words, bytes, random);
}

Seeds obj_seeds() {
    return {bytes_of(seed)};
}

}  // namespace

const Target obj_target{"obj", take_obj, obj_seeds, 500, damage_obj};

// What `equistream model` makes of a description and its model.

namespace {

constexpr std::size_t head_bytes = 3;

/// Two bytes say how long the description is and one what is asked of the model, which is what follows it.
void take_scene_and_model(Bytes bytes) {
    Choices choices(bytes);
    const auto size = choices.take<std::uint16_t>();
    const int asked = choices.below(8);
    const Bytes description = choices.take_bytes(size);
    scratch_file("shown.glb", bytes.subspan(std::min(bytes.size(), head_bytes + description.size())));
    const SceneDescription scene = load_scene(scratch_file("shown.json", description));
    const SceneModel whole = load_model(scene, {.shading = false});
    constexpr std::size_t max_triangles = 2000;  // more are slow, and show nothing that these do not
    if (whole.triangle_count() > max_triangles || scene.camera_path.keys().size() > 16)
        return;
    ClientModelOptions options{
        .error_rad = 0.01, .silhouette_rad = 0.02, .visibility_rays = 2000, .check_rays = 500, .rounds = 2};
    if (asked == 1)
        options.error_rad = 0;
    if (asked == 2)
        options.silhouette_rad = 0;
    if (asked == 3)
        options.ipd_m = -1;
    if (asked >= 4)
        options.ipd_m = 0;
    const ClientModel made = build_client_model(
        whole, scene, options, [](const std::string& step) { require(!step.empty(), "each step is told"); });
    check_promises(made.model);
    require(made.figures.triangles_after <= made.figures.triangles_before,
            "a model has no more triangles than its scene");
    const std::filesystem::path file = scratch_file("made.json", {});
    write_client_model(file, made, scene);
    const SceneDescription again = load_scene(file);
    require(again.stands_for == scene.geometry_fingerprint, "a model says whose geometry it stands for");
    require(load_model(again, {.shading = false}).triangle_count() == made.model.triangle_count(),
            "a model read again has its triangles");
}

std::vector<std::uint8_t> joined(std::string_view description, const std::string& model) {
    std::vector<std::uint8_t> bytes{std::uint8_t(description.size() & 0xff), std::uint8_t(description.size() >> 8), 0};
    for (const std::string_view part : {description, std::string_view(model)})
        bytes.insert(bytes.end(), part.begin(), part.end());
    return bytes;
}

Seeds scene_and_model_seeds() {
    constexpr std::string_view still =
        R"({"model": "shown.glb", "sun": {"towards": [0, 2, 1], "irradiance": 1}, "head_box": {"lean_m": 0.1},
            "camera": {"keys": [{"time_s": 0, "position_m": [0.3, 0.3, 2], "look_at_m": [0.3, 0.3, 0]},
                                {"time_s": 1, "position_m": [0.5, 0.3, 2], "look_at_m": [0.3, 0.3, 0]}]}})";
    constexpr std::string_view moving =
        R"({"model": "shown.glb", "camera": {"keys": [{"time_s": 0, "position_m": [0, 0, 4]}]}, "head_box": {"lean_m": 0.1},
            "moving": [{"object": "twig", "keys": [{"time_s": 0, "position_m": [0, 0, 0]},
                                                   {"time_s": 1, "position_m": [1, 0, 0]}]}]})";
    return {joined(still, test::GltfBuilder::triangle().glb()), joined(moving, rich().glb())};
}

}  // namespace

const Target client_model_target{"client_model", take_scene_and_model, scene_and_model_seeds, 150};

}  // namespace equistream::fuzz
