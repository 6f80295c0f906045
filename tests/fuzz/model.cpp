/// A model: GLB, or glTF with its buffer in a data URI.
#include "scenes/gltf_builder.h"
#include "scenes/png_bytes.h"
#include "target.h"

#include <equistream_scene/model.h>

#include <algorithm>

namespace equistream::fuzz {

namespace {

void check(const Mesh& mesh, const SceneModel& model) {
    require(mesh.material < model.materials.size(), "a mesh's material is there");
    require(mesh.normals.empty() || mesh.normals.size() == mesh.positions.size(), "one normal a position, or none");
    require(mesh.uvs.empty() || mesh.uvs.size() == mesh.positions.size(), "one texture coordinate a position, or none");
    for (const glm::uvec3& corner : mesh.triangles)
        require(std::max({corner.x, corner.y, corner.z}) < mesh.positions.size(), "a triangle's corners are there");
}

void read(Bytes bytes) {
    const SceneModel model = load_model(scratch_file("model.gltf", bytes));
    require(model.triangle_count() > 0, "there is a triangle");
    for (const Mesh& mesh : model.meshes)
        check(mesh, model);
    for (const Instance& instance : model.instances)
        require(instance.mesh < model.meshes.size() && instance.object < model.objects.size(),
                "what an instance places is there");
    for (const AlphaMask& mask : model.alpha_masks)
        require(mask.opaque.size() == static_cast<std::size_t>(mask.width) * static_cast<std::size_t>(mask.height),
                "a mask has its texels");
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

Seeds seeds() {
    const test::GltfBuilder triangle = test::GltfBuilder::triangle();
    // The buffer of triangle(): nine floats 0 or 1 and three indices.
    const std::string uri = "data:application/octet-stream;base64,"
                            "AAAAAAAAAAAAAAAAAACAPwAAAAAAAAAAAAAAAAAAgD8AAAAAAAABAAIA";
    return {bytes_of(triangle.glb()), bytes_of(triangle.gltf(uri)), bytes_of(rich().glb())};
}

}  // namespace

const Target model_target{"model", read, seeds, 15000};

}  // namespace equistream::fuzz
