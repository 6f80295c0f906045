/// A model: GLB, or glTF with its buffer in a data URI.
#include "model_promises.h"
#include "target.h"

#include <scenes/library/model.h>
#include <tests/unit/scenes/gltf_builder.h>
#include <tests/unit/scenes/temporary_folder.h>

namespace equistream::fuzz {

namespace {

void read(Bytes bytes) {
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
