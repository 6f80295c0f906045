#include <tests/unit/scenes/gltf_builder.h>
#include <tests/unit/scenes/temporary_folder.h>

#include <scenes/library/model.h>

#include <glm/gtc/matrix_transform.hpp>
#include <glm/gtc/quaternion.hpp>

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

namespace equistream::test {

namespace {

class ModelTest : public TemporaryFolder {
protected:
    SceneModel load(const GltfBuilder& builder, const ModelOptions& options = {}) const {
        return load_model(write("model.glb", builder.glb()), options);
    }
};

void expect_near(const glm::vec3& a, const glm::vec3& b, float tolerance = 1e-6f) {
    EXPECT_LE(glm::length(a - b), tolerance)
        << a.x << " " << a.y << " " << a.z << " instead of " << b.x << " " << b.y << " " << b.z;
}

constexpr glm::vec3 corner(const SceneModel& model, int c) {
    return model.meshes[0].positions[model.meshes[0].triangles[0][c]];
}

}  // namespace

TEST_F(ModelTest, LeastModel) {
    const SceneModel model = load(GltfBuilder::triangle());
    ASSERT_EQ(model.meshes.size(), 1u);
    ASSERT_EQ(model.instances.size(), 1u);
    EXPECT_EQ(model.triangle_count(), 1u);
    EXPECT_EQ(model.objects[model.instances[0].object].name, "one");
    EXPECT_TRUE(model.meshes[0].normals.empty());
    EXPECT_TRUE(model.meshes[0].uvs.empty());
    ASSERT_EQ(model.materials.size(), 1u);
    EXPECT_EQ(model.meshes[0].material, 0u);
    expect_near(corner(model, 1), {1, 0, 0});
}

TEST_F(ModelTest, QuantisedAttributes) {
    GltfBuilder builder;
    builder.json["extensionsUsed"] = {"KHR_mesh_quantization"};
    builder.json["extensionsRequired"] = {"KHR_mesh_quantization"};
    // Normalised 16-bit positions, stride 8; normals as int8, stride 4; uvs as unsigned 16-bit.
    const int positions =
        builder.accessor<std::int16_t>({0, 0, 0, 0, 32767, 0, 0, 0, 0, -32768, 0, 0}, gl_short, "VEC3", 3, 8);
    builder.json["accessors"][positions]["normalized"] = true;
    const int normals =
        builder.accessor<std::int8_t>({0, 0, 127, 0, 0, -128, 0, 0, 90, 0, 90, 0}, gl_byte, "VEC3", 3, 4);
    builder.json["accessors"][normals]["normalized"] = true;
    const int uvs = builder.accessor<std::uint16_t>({0, 0, 65535, 0, 0, 32768}, gl_unsigned_short, "VEC2", 3);
    builder.json["accessors"][uvs]["normalized"] = true;
    const int image = builder.view(png_rgba(1, 1, {255, 255, 255, 255}));
    builder.json["images"] = {{{"bufferView", image}, {"mimeType", "image/png"}}};
    builder.json["textures"] = {{{"source", 0}}};
    builder.json["materials"] = {{{"pbrMetallicRoughness", {{"baseColorTexture", {{"index", 0}}}}}}};
    builder.node({{"mesh", builder.mesh({{"POSITION", positions}, {"NORMAL", normals}, {"TEXCOORD_0", uvs}}, -1, 0)}});
    const SceneModel model = load(builder);
    const Mesh& mesh = model.meshes[0];
    expect_near(mesh.positions[1], {1, 0, 0});
    expect_near(mesh.positions[2], {0, -1, 0});
    expect_near(mesh.normals[0], {0, 0, 1});
    expect_near(mesh.normals[1], {0, -1, 0});
    expect_near(mesh.normals[2], {std::sqrt(0.5f), 0, std::sqrt(0.5f)});
    EXPECT_FLOAT_EQ(mesh.uvs[1].x, 1);
    EXPECT_NEAR(mesh.uvs[2].y, 32768.0 / 65535, 1e-7);
}

TEST_F(ModelTest, UnnormalisedQuantisedPositionsAreScaledByTheNode) {
    GltfBuilder builder;
    const int positions =
        builder.accessor<std::uint16_t>({0, 0, 0, 0, 1000, 0, 0, 0, 0, 65535, 0, 0}, gl_unsigned_short, "VEC3", 3, 8);
    builder.node({{"mesh", builder.mesh({{"POSITION", positions}})}, {"scale", {0.001, 0.001, 0.001}}});
    const SceneModel model = load(builder);
    expect_near(glm::vec3(model.instances[0].world_from_object * glm::vec4(corner(model, 1), 1)), {1, 0, 0});
    expect_near(glm::vec3(model.instances[0].world_from_object * glm::vec4(corner(model, 2), 1)), {0, 65.535f, 0},
                1e-4f);
}

TEST_F(ModelTest, SparseAccessors) {
    GltfBuilder builder;
    const int positions = builder.accessor<float>({0, 0, 0, 1, 0, 0, 0, 1, 0}, gl_float, "VEC3", 3);
    const int indices = builder.view(GltfBuilder::bytes_of<std::uint8_t>({2}));
    const int values = builder.view(GltfBuilder::bytes_of<float>({5, 6, 7}));
    builder.json["accessors"][positions]["sparse"] = {
        {"count", 1},
        {"indices", {{"bufferView", indices}, {"componentType", gl_unsigned_byte}, {"byteOffset", 0}}},
        {"values", {{"bufferView", values}, {"byteOffset", 0}}}};
    builder.node({{"mesh", builder.mesh({{"POSITION", positions}})}});
    const SceneModel model = load(builder);
    expect_near(corner(model, 1), {1, 0, 0});
    expect_near(corner(model, 2), {5, 6, 7});
}

TEST_F(ModelTest, IndexTypesStripsAndFans) {
    GltfBuilder builder;
    const int square = builder.accessor<float>({0, 0, 0, 1, 0, 0, 0, 1, 0, 1, 1, 0}, gl_float, "VEC3", 4);
    const int bytes = builder.accessor<std::uint8_t>({0, 1, 2, 2, 1, 3}, gl_unsigned_byte, "SCALAR", 6);
    const int words = builder.accessor<std::uint32_t>({0, 1, 2, 2, 1, 3}, gl_unsigned_int, "SCALAR", 6);
    const int strip = builder.accessor<std::uint16_t>({0, 1, 2, 3}, gl_unsigned_short, "SCALAR", 4);
    const int fan = builder.accessor<std::uint16_t>({0, 1, 3, 2}, gl_unsigned_short, "SCALAR", 4);
    const Json attributes = {{"POSITION", square}};
    for (const int mesh :
         {builder.mesh(attributes, bytes), builder.mesh(attributes, words), builder.mesh(attributes, strip, -1, 5),
          builder.mesh(attributes, fan, -1, 6), builder.mesh(attributes, strip, -1, 0)})
        builder.node({{"mesh", mesh}});
    const SceneModel model = load(builder);
    EXPECT_EQ(model.instances.size(), 4u);  // points have no surface
    EXPECT_EQ(model.triangle_count(), 8u);
    for (const Instance& instance : model.instances) {
        double area = 0;
        const Mesh& mesh = model.meshes[instance.mesh];
        for (const glm::uvec3& t : mesh.triangles) {
            const glm::vec3 twice =
                glm::cross(mesh.positions[t.y] - mesh.positions[t.x], mesh.positions[t.z] - mesh.positions[t.x]);
            EXPECT_GT(twice.z, 0) << "a triangle of mesh " << instance.mesh << " is turned over";
            area += twice.z / 2;
        }
        EXPECT_NEAR(area, 1, 1e-6);
    }
}

TEST_F(ModelTest, NodeHierarchyAndMirroredMatrices) {
    GltfBuilder builder = GltfBuilder::triangle();
    builder.json["nodes"] = Json::array();
    // Column-major matrix: mirrors x, then moves by (1, 2, 3).
    builder.node(
        {{"name", "mirror"}, {"matrix", {-1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 1, 2, 3, 1}}, {"children", {1}}});
    const double half = std::sqrt(0.5);
    builder.node({{"name", "turned"},
                  {"mesh", 0},
                  {"translation", {0, 0, 1}},
                  {"rotation", {0, 0, half, half}},
                  {"scale", {2, 2, 2}}});
    builder.json["scenes"] = {{{"nodes", {0}}}};
    builder.json["scene"] = 0;
    const SceneModel model = load(builder);
    ASSERT_EQ(model.instances.size(), 1u);
    const Instance& instance = model.instances[0];
    EXPECT_EQ(model.objects[instance.object].name, "turned");
    EXPECT_EQ(model.objects[instance.object].parent, 0);
    // (1,0,0) -> scaled (2,0,0) -> turned 90 degrees about z (0,2,0) -> moved (0,2,1) -> mirrored and moved (1,4,4).
    expect_near(glm::vec3(instance.world_from_object * glm::vec4(1, 0, 0, 1)), {1, 4, 4});
    expect_near(glm::vec3(instance.world_from_object * glm::vec4(0, 1, 0, 1)), {3, 2, 4});
    EXPECT_LT(glm::determinant(glm::mat3(instance.world_from_object)), 0);
}

TEST_F(ModelTest, MaterialsAndExtensionValues) {
    GltfBuilder builder = GltfBuilder::triangle();
    builder.json["extensionsRequired"] = {"KHR_materials_transmission"};
    builder.json["materials"] = {
        {{"name", "glass"},
         {"pbrMetallicRoughness",
          {{"baseColorFactor", {0.5, 0.6, 0.7, 1.0}}, {"metallicFactor", 0}, {"roughnessFactor", 0.25}}},
         {"doubleSided", true},
         {"extensions",
          {{"KHR_materials_transmission", {{"transmissionFactor", 1}}}, {"KHR_materials_ior", {{"ior", 1.33}}}}}},
        {{"name", "lamp"},
         {"emissiveFactor", {1.0, 0.5, 0.25}},
         {"extensions", {{"KHR_materials_emissive_strength", {{"emissiveStrength", 16}}}}}}};
    builder.json["meshes"][0]["primitives"][0]["material"] = 1;
    const SceneModel model = load(builder);
    ASSERT_EQ(model.materials.size(), 3u);
    const Material& glass = model.materials[0];
    expect_near(glass.base_colour, {0.5f, 0.6f, 0.7f});
    EXPECT_EQ(glass.transmission, 1);
    EXPECT_FLOAT_EQ(glass.index_of_refraction, 1.33f);
    EXPECT_FLOAT_EQ(glass.roughness, 0.25f);
    EXPECT_TRUE(glass.double_sided);
    expect_near(model.materials[1].emission, {16, 8, 4});
    EXPECT_EQ(model.materials[1].index_of_refraction, 1.5f);
    EXPECT_EQ(model.meshes[0].material, 1u);

    auto& ior = builder.json["materials"][0]["extensions"]["KHR_materials_ior"]["ior"];
    ior = 0;
    EXPECT_EQ(load(builder).materials[0].index_of_refraction, 1000) << "the extension's word for infinity";
    for (const double bad : {-1.0, 0.5}) {
        ior = bad;
        expect_contains(input_error([&] { load(builder); }), "expected an ior of 0 or from 1, found ");
    }
}

namespace {

/// A masked triangle with a 2x2 texture: top left opaque, the others at alpha 0, 100 and 200.
GltfBuilder masked_triangle(bool external) {
    GltfBuilder builder = GltfBuilder::triangle();
    const std::string png = png_rgba(2, 2, {9, 9, 9, 255, 9, 9, 9, 0, 9, 9, 9, 100, 9, 9, 9, 200});
    if (external)
        builder.json["images"] = {{{"uri", "leaf%20texture.png"}}};
    else
        builder.json["images"] = {{{"bufferView", builder.view(png)}, {"mimeType", "image/png"}}};
    builder.json["samplers"] = {{{"wrapS", 33071}, {"wrapT", 33648}, {"magFilter", 9728}}};
    builder.json["textures"] = {{{"source", 0}, {"sampler", 0}}};
    builder.json["materials"] = {{{"alphaMode", "MASK"},
                                  {"alphaCutoff", 0.5},
                                  {"pbrMetallicRoughness", {{"baseColorTexture", {{"index", 0}}}}}}};
    const int uvs = builder.accessor<float>({0, 0, 1, 0, 0, 1}, gl_float, "VEC2", 3);
    builder.json["meshes"][0]["primitives"][0]["material"] = 0;
    builder.json["meshes"][0]["primitives"][0]["attributes"]["TEXCOORD_0"] = uvs;
    return builder;
}

void expect_mask_of_masked_triangle(const SceneModel& model) {
    ASSERT_EQ(model.alpha_masks.size(), 1u);
    ASSERT_EQ(model.materials[0].alpha_mask, 0u);
    const AlphaMask& mask = model.alpha_masks[0];
    EXPECT_EQ(mask.opaque, (std::vector<std::uint8_t>{255, 0, 0, 255}));
    EXPECT_EQ(mask.wrap_u, Wrap::clamp);
    EXPECT_EQ(mask.wrap_v, Wrap::mirror);
    EXPECT_TRUE(mask.covers({0.2f, 0.2f}));
    EXPECT_FALSE(mask.covers({0.7f, 0.2f}));
    EXPECT_FALSE(mask.covers({7.0f, 0.2f}));   // clamped to the right
    EXPECT_TRUE(mask.covers({-7.0f, 0.2f}));   // clamped to the left
    EXPECT_TRUE(mask.covers({0.7f, 1.3f}));    // mirrored: v = 0.7
    EXPECT_FALSE(mask.covers({0.7f, -0.2f}));  // mirrored: v = 0.2
    EXPECT_TRUE(mask.covers({0.7f, 98.7f}));   // mirrored 98 times: v = 0.7
}

}  // namespace

TEST_F(ModelTest, AlphaMaskWithCutoffAndWrap) {
    const SceneModel model = load(masked_triangle(false));
    expect_mask_of_masked_triangle(model);
    ASSERT_EQ(model.textures.size(), 1u);
    EXPECT_TRUE(model.textures[0].nearest);
    EXPECT_EQ(model.textures[0].mime_type, "image/png");
    EXPECT_EQ(model.textures[0].encoded.at(1), 'P');
}

/// Whether or not there are texture coordinates, and for clients, which read less.
TEST_F(ModelTest, WhatIsCutAwayWholeIsNotThere) {
    for (const float alpha : {0.4f, 0.6f})
        for (const bool shading : {false, true}) {
            GltfBuilder builder = GltfBuilder::triangle();
            builder.json["materials"] = {
                {{"alphaMode", "MASK"}, {"pbrMetallicRoughness", {{"baseColorFactor", {1, 1, 1, alpha}}}}},
                nlohmann::json::object()};
            builder.json["meshes"][0]["primitives"][0]["material"] = 0;
            builder.json["meshes"][0]["primitives"].push_back(builder.json["meshes"][0]["primitives"][0]);
            builder.json["meshes"][0]["primitives"][1]["material"] = 1;
            EXPECT_EQ(load(builder, {.shading = shading}).triangle_count(), alpha < 0.5f ? 1u : 2u) << alpha << shading;
        }
}

TEST_F(ModelTest, TextureTransformsMoveTheCoordinates) {
    const auto uvs_with = [&](const Json& transform, const char* texture = "baseColorTexture") {
        GltfBuilder builder = masked_triangle(false);
        builder.json["extensionsRequired"] = {"KHR_texture_transform"};
        builder.json["materials"][0]["pbrMetallicRoughness"][texture]["index"] = 0;
        builder.json["materials"][0]["pbrMetallicRoughness"][texture]["extensions"]["KHR_texture_transform"] =
            transform;
        return load(builder).meshes[0].uvs;
    };
    const auto expect_uvs = [](const std::vector<glm::vec2>& uvs, const std::vector<glm::vec2>& expected) {
        ASSERT_EQ(uvs.size(), expected.size());
        for (std::size_t i = 0; i < uvs.size(); ++i) {
            EXPECT_NEAR(uvs[i].x, expected[i].x, 1e-6) << i;
            EXPECT_NEAR(uvs[i].y, expected[i].y, 1e-6) << i;
        }
    };
    // Corners (0, 0), (1, 0) and (0, 1).
    expect_uvs(uvs_with({{"offset", {0.25, -1}}}), {{0.25f, -1}, {1.25f, -1}, {0.25f, 0}});
    expect_uvs(uvs_with({{"scale", {2, -3}}}), {{0, 0}, {2, 0}, {0, -3}});
    // The extension's own example: the lower left quadrant of the picture, whose v runs down, turned by 90 degrees.
    expect_uvs(uvs_with({{"offset", {0, 1}}, {"rotation", std::numbers::pi / 2}, {"scale", {0.5, 0.5}}}),
               {{0, 1}, {0, 0.5f}, {0.5f, 1}});
    EXPECT_TRUE(uvs_with({{"texCoord", 1}}).empty()) << "the mesh has no TEXCOORD_1";
    expect_contains(input_error([&] {
                        uvs_with({{"scale", {2, 2}}}, "metallicRoughnessTexture");
                    }),
                    "textures that share one KHR_texture_transform, found two");
    expect_contains(input_error([&] { uvs_with({{"scale", {2}}}); }), "two numbers as scale");
    expect_contains(input_error([&] { uvs_with({{"rotation", "a quarter"}}); }), "finite numbers");
}

TEST_F(ModelTest, OneNoteSaysWhatIsLeftOut) {
    EXPECT_TRUE(load(GltfBuilder::triangle()).notes.empty());
    GltfBuilder builder = masked_triangle(false);
    builder.json["materials"][0]["normalTexture"] = {{"index", 0}};
    builder.json["materials"][0]["extensions"]["KHR_materials_volume"] = {{"thicknessFactor", 1}};
    auto& primitive = builder.json["meshes"][0]["primitives"][0];
    primitive["attributes"]["COLOR_0"] = primitive["attributes"]["POSITION"];
    builder.json["animations"] = {{{"channels", Json::array()}, {"samplers", Json::array()}}};
    const auto notes = load(builder).notes;
    ASSERT_EQ(notes.size(), 1u);
    expect_contains(notes[0], "model.glb: left out: normal maps (1 material), volume (1 material), vertex colours (1 "
                              "primitive) and animations (1 animation)");
    const auto of_geometry = load(builder, {.shading = false}).notes;
    ASSERT_EQ(of_geometry.size(), 1u);
    expect_contains(of_geometry[0], "model.glb: left out: animations (1 animation)");
}

TEST_F(ModelTest, OneNoteSaysWhatIsShownOtherwise) {
    GltfBuilder builder = GltfBuilder::triangle();
    builder.json["extensionsUsed"] = {"KHR_materials_unlit", "EXT_mesh_gpu_instancing", "VENDOR_odd"};
    builder.json["materials"] = {
        {{"extensions", {{"KHR_materials_unlit", Json::object()}}}},
        {{"extensions",
          {{"KHR_materials_transmission", {{"transmissionFactor", 1}, {"transmissionTexture", {{"index", 0}}}}}}}},
        {{"extensions",
          {{"KHR_materials_pbrSpecularGlossiness",
            {{"diffuseFactor", {0.5, 0.25, 0.125, 1}}, {"glossinessFactor", 0.25}}}}}},
        {{"pbrMetallicRoughness", {{"baseColorFactor", {0, 0, 1, 1}}}},
         {"extensions", {{"KHR_materials_pbrSpecularGlossiness", {{"diffuseFactor", {1, 0, 0, 1}}}}}}}};
    builder.json["nodes"][0]["extensions"]["EXT_mesh_gpu_instancing"] = Json::object();
    const SceneModel model = load(builder);
    ASSERT_EQ(model.notes.size(), 1u);
    expect_contains(model.notes[0], "left out: colours that no light changes (1 material), specular colours (2 "
                                    "materials), textures of transmission, taken as opaque (1 material), copies (1 "
                                    "node) and VENDOR_odd");
    EXPECT_EQ(model.materials[1].transmission, 0);
    expect_near(model.materials[2].base_colour, {0.5f, 0.25f, 0.125f});
    EXPECT_EQ(model.materials[2].metallic, 0);
    EXPECT_EQ(model.materials[2].roughness, 0.75f);
    expect_near(model.materials[3].base_colour, {0, 0, 1});
}

TEST_F(ModelTest, AlphaMaskAnywhereOnThePlane) {
    AlphaMask mask;
    mask.width = 5;
    mask.height = 1;
    for (const Wrap wrap : {Wrap::repeat, Wrap::mirror, Wrap::clamp}) {
        mask.wrap_u = wrap;
        for (int i = -40; i < 40; ++i) {
            // Texel by integers alone: i counts texels from u = 0.
            const int repeated = (i % 5 + 5) % 5;
            const int mirrored = (i % 10 + 10) % 10 < 5 ? repeated : 4 - repeated;
            const int expected = wrap == Wrap::repeat   ? repeated
                                 : wrap == Wrap::mirror ? mirrored
                                                        : std::clamp(i, 0, 4);
            mask.opaque.assign(5, 0);
            mask.opaque[static_cast<std::size_t>(expected)] = 255;
            EXPECT_TRUE(mask.covers({(static_cast<float>(i) + 0.5f) / 5, 0.5f})) << i;
        }
        for (const float far : {1e9f, -1e30f, std::numeric_limits<float>::quiet_NaN()})
            mask.covers({far, far});  // any answer, but within the image
    }
}

TEST_F(ModelTest, ClientLoadsOnlyItsShare) {
    const SceneModel model = load(masked_triangle(false), {.shading = false});
    expect_mask_of_masked_triangle(model);
    EXPECT_TRUE(model.textures.empty());
    EXPECT_EQ(model.meshes[0].uvs.size(), 3u);
    EXPECT_EQ(model.materials[0].base_colour_texture, no_index);
}

TEST_F(ModelTest, ExternalFilesAndDataUris) {
    const GltfBuilder builder = masked_triangle(true);
    write("folder/leaf texture.png", png_rgba(2, 2, {9, 9, 9, 255, 9, 9, 9, 0, 9, 9, 9, 100, 9, 9, 9, 200}));
    write("folder/data.bin", builder.buffer);
    expect_mask_of_masked_triangle(load_model(write("folder/model.gltf", builder.gltf("data.bin"))));

    static constexpr char digits[] = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
    std::string base64;
    for (std::size_t i = 0; i < builder.buffer.size(); i += 3) {
        unsigned bits = 0;
        for (std::size_t k = 0; k < 3; ++k)
            bits = bits << 8 | (i + k < builder.buffer.size() ? static_cast<std::uint8_t>(builder.buffer[i + k]) : 0u);
        for (std::size_t k = 0; k < 4; ++k)
            base64 += i + k <= builder.buffer.size() ? digits[bits >> (18 - 6 * k) & 63] : '=';
    }
    expect_mask_of_masked_triangle(
        load_model(write("folder/inline.gltf", builder.gltf("data:application/octet-stream;base64," + base64))));
}

TEST_F(ModelTest, MissingExternalFilesAreErrors) {
    const GltfBuilder builder = masked_triangle(true);
    write("data.bin", builder.buffer);
    const std::string model = write("model.gltf", builder.gltf("data.bin")).string();
    std::string error = input_error([&] { load_model(model); });
    expect_contains(error, model);
    expect_contains(error, "leaf%20texture.png");
    std::filesystem::remove(folder_ / "data.bin");
    error = input_error([&] { load_model(model); });
    expect_contains(error, model);
    expect_contains(error, "data.bin");
}

}  // namespace equistream::test
