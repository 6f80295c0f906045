/// Models, and what clients need of them.
#include "target.h"

#include <client/model/client_model.h>
#include <scenes/library/model.h>
#include <scenes/library/scene.h>
#include <tests/unit/scenes/gltf_builder.h>
#include <tests/unit/scenes/temporary_folder.h>

#include <algorithm>

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

Seeds model_seeds() {
    const test::GltfBuilder triangle = test::GltfBuilder::triangle();
    // The buffer of triangle(): nine floats 0 or 1 and three indices.
    const std::string uri = "data:application/octet-stream;base64,"
                            "AAAAAAAAAAAAAAAAAACAPwAAAAAAAAAAAAAAAAAAgD8AAAAAAAABAAIA";
    return {bytes_of(triangle.glb()), bytes_of(triangle.gltf(uri)), bytes_of(rich().glb())};
}

}  // namespace

const Target model_target{"model", take_model, model_seeds, 15000};

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
usemtl none
f 1 2 3 4 1
)";

void take_obj(Bytes bytes) {
    scratch_file("model.mtl", bytes);
    check_promises(load_model(scratch_file("model.obj", bytes)));
}

Seeds obj_seeds() {
    return {bytes_of(seed)};
}

}  // namespace

const Target obj_target{"obj", take_obj, obj_seeds, 8000};

// What `equistream model` makes of a description and its model.

namespace {

constexpr std::size_t head_bytes = 2;

/// Two bytes say how long the description is; the model is what follows it.
void take_scene_and_model(Bytes bytes) {
    Choices choices(bytes);
    const Bytes description = choices.take_bytes(choices.take<std::uint16_t>());
    scratch_file("shown.glb", bytes.subspan(std::min(bytes.size(), head_bytes + description.size())));
    const SceneDescription scene = load_scene(scratch_file("shown.json", description));
    const SceneModel whole = load_model(scene, {.shading = false});
    constexpr std::size_t most_triangles = 2000;  // more are slow, and show nothing that these do not
    if (whole.triangle_count() > most_triangles || scene.camera_path.keys().size() > 16)
        return;
    const ClientModel made = build_client_model(
        whole, scene,
        {.error_rad = 0.01, .silhouette_rad = 0.02, .visibility_rays = 2000, .check_rays = 500, .rounds = 2});
    check_promises(made.model);
    require(made.figures.triangles_after <= made.figures.triangles_before,
            "a model has no more triangles than its scene");
}

std::vector<std::uint8_t> joined(std::string_view description, const std::string& model) {
    std::vector<std::uint8_t> bytes{std::uint8_t(description.size() & 0xff), std::uint8_t(description.size() >> 8)};
    for (const std::string_view part : {description, std::string_view(model)})
        bytes.insert(bytes.end(), part.begin(), part.end());
    return bytes;
}

Seeds scene_and_model_seeds() {
    constexpr std::string_view still =
        R"({"model": "shown.glb", "sun": {"towards": [0, 2, 1], "irradiance": 1}, "head_box": {"lean_m": 0.1},
            "camera": {"keys": [{"time_s": 0, "position_m": [0.3, 0.3, 2], "look_at_m": [0.3, 0.3, 0]},
                                {"time_s": 1, "position_m": [0.5, 0.3, 2], "look_at_m": [0.3, 0.3, 0]}]}})";
    return {joined(still, test::GltfBuilder::triangle().glb())};
}

}  // namespace

const Target client_model_target{"client_model", take_scene_and_model, scene_and_model_seeds, 200};

}  // namespace equistream::fuzz
