// Files that lie, end early or ask for too much: each must end in one InputError that names the file.
#include <tests/unit/scenes/gltf_builder.h>
#include <tests/unit/scenes/temporary_folder.h>

#include <scenes/library/scene.h>

#include <sys/resource.h>

#include <new>
#include <random>

namespace equistream::test {

namespace {

class HostileModelTest : public TemporaryFolder {
protected:
    std::string refusal(const GltfBuilder& builder) const { return refusal(builder.glb()); }
    std::string refusal(const std::string& bytes) const {
        const std::filesystem::path file = write("hostile.glb", bytes);
        const std::string error = input_error([&] { load_model(file); });
        EXPECT_EQ(error.rfind(file.string(), 0), 0u) << "the file should come first: " << error;
        return error;
    }
};

}  // namespace

TEST_F(HostileModelTest, MissingFileFolderAndNonsense) {
    expect_contains(input_error([&] { load_model(folder_ / "none.glb"); }),
                    "none.glb: expected a glTF model, found no such file");
    expect_contains(input_error([&] { load_model(folder_); }), "not a regular file");
    expect_contains(refusal(std::string()), "glTF");
    expect_contains(refusal(std::string("this is not a model")), "glTF");
    refusal(std::string(100, '['));
    expect_contains(refusal(std::string(100000, '[')), "nested");
}

#if !defined(__SANITIZE_ADDRESS__) && !defined(__SANITIZE_THREAD__)  // which reserve more than any limit
TEST_F(HostileModelTest, OutOfMemoryIsNotTheModelsFault) {
    constexpr std::uint64_t bytes = std::uint64_t{15} << 28;  // none of them on the disk
    std::filesystem::resize_file(write("large.bin", ""), bytes);
    GltfBuilder builder = GltfBuilder::triangle();
    builder.json["buffers"] = Json::array({{{"byteLength", bytes}, {"uri", "large.bin"}}});
    const std::filesystem::path file = write("large.gltf", builder.json.dump());
    rlimit before{};
    ASSERT_EQ(getrlimit(RLIMIT_AS, &before), 0);
    const rlimit less{std::uint64_t{12} << 28, before.rlim_max};
    ASSERT_EQ(setrlimit(RLIMIT_AS, &less), 0);
    EXPECT_THROW(load_model(file), std::bad_alloc);
    EXPECT_EQ(setrlimit(RLIMIT_AS, &before), 0);
}
#endif

TEST_F(HostileModelTest, TruncatedAtEveryByte) {
    const std::string whole = GltfBuilder::triangle().glb();
    for (std::size_t length = 0; length < whole.size(); ++length)
        refusal(whole.substr(0, length));
    expect_contains(refusal(whole.substr(0, whole.size() - 1)), "truncated");
}

TEST_F(HostileModelTest, EarlierVersionsAreNamed) {
    std::string binary = GltfBuilder::triangle().glb();
    binary[4] = 1;
    expect_contains(refusal(binary), "expected a glTF 2.0 model, found version 1");
    GltfBuilder builder = GltfBuilder::triangle();
    builder.json["asset"]["version"] = "1.0";
    expect_contains(refusal(builder), "expected a glTF 2.0 model, found version 1.0");
}

TEST_F(HostileModelTest, IndicesOutOfRange) {
    GltfBuilder builder = GltfBuilder::triangle();
    builder.buffer[builder.buffer.size() - 2] = 3;
    expect_contains(refusal(builder), "mesh 0, primitive 0: expected indices below 3, found 3");
}

TEST_F(HostileModelTest, ReferencesOutOfRange) {
    const auto broken = [](const char* pointer, const Json& value) {
        GltfBuilder builder = GltfBuilder::triangle();
        builder.json[Json::json_pointer(pointer)] = value;
        return builder;
    };
    expect_contains(refusal(broken("/accessors/0/bufferView", 9)), "buffer view");
    expect_contains(refusal(broken("/bufferViews/0/buffer", 4)), "buffer");
    expect_contains(refusal(broken("/bufferViews/0/byteOffset", 1u << 30)), "buffer");
    expect_contains(refusal(broken("/bufferViews/0/byteLength", 1u << 30)), "buffer");
    expect_contains(refusal(broken("/accessors/0/byteOffset", 40)), "accessor 0");
    expect_contains(refusal(broken("/accessors/0/count", 4)), "accessor 0");
    expect_contains(refusal(broken("/accessors/0/count", 4000000000u)), "2^28");
    expect_contains(refusal(broken("/accessors/1/count", 2)), "multiple of 3");
    expect_contains(refusal(broken("/accessors/0/type", "VEC2")), "components");
    expect_contains(refusal(broken("/accessors/1/componentType", gl_short)), "unsigned");
    expect_contains(refusal(broken("/bufferViews/0/byteStride", 4)), "stride");
    expect_contains(refusal(broken("/meshes/0/primitives/0/material", 0)), "material");
    expect_contains(refusal(broken("/meshes/0/primitives/0/indices", 7)), "accessor");
    expect_contains(refusal(broken("/meshes/0/primitives/0/attributes", {{"NORMAL", 0}})), "POSITION");
    expect_contains(refusal(broken("/nodes/0/mesh", 2)), "mesh");
    GltfBuilder cycle = broken("/nodes/0/children", {0});
    refusal(cycle);
    cycle.json["scenes"] = {{{"nodes", {0}}}};
    expect_contains(refusal(cycle), "a cycle");
    expect_contains(refusal(broken("/nodes/0/scale", {1, 1})), "scale");
    refusal(broken("/scenes", {{{"nodes", {5}}}}));
}

TEST_F(HostileModelTest, AbsurdCountsWithoutBytes) {
    GltfBuilder builder = GltfBuilder::triangle();
    builder.json["accessors"][0].erase("bufferView");
    builder.json["accessors"][0]["count"] = 30000000;
    expect_contains(refusal(builder), "without a buffer view");
    // An accessor within the limit, as often as one likes.
    GltfBuilder often = GltfBuilder::triangle();
    often.json["accessors"][0].erase("bufferView");
    often.json["accessors"][0]["count"] = (1 << 20) - 1;
    load_model(write("once.glb", often.glb()));
    Json& primitives = often.json["meshes"][0]["primitives"];
    primitives.push_back(primitives[0]);
    expect_contains(refusal(often), "expected at most 2^20 elements without a buffer view, of all meshes together");
    primitives.erase(1);
    primitives[0]["attributes"]["NORMAL"] = primitives[0]["attributes"]["POSITION"];
    expect_contains(refusal(often), "expected at most 2^20 elements without a buffer view, of all meshes together");
}

TEST_F(HostileModelTest, FactorsOutOfRange) {
    const auto refused = [&](const Json& material) {
        GltfBuilder builder = GltfBuilder::triangle();
        builder.json["materials"] = {material};
        builder.json["meshes"][0]["primitives"][0]["material"] = 0;
        const std::filesystem::path file = write("hostile.glb", builder.glb());
        return input_error([&] { load_model(file, {.shading = true}); });
    };
    for (const auto& [name, value] : {std::pair<const char*, Json>{"metallicFactor", -3},
                                      {"roughnessFactor", 1e30},
                                      {"baseColorFactor", {-4, 1, 1, 1}},
                                      {"baseColorFactor", {1, 1, 1e300, 1}}})
        expect_contains(refused({{"pbrMetallicRoughness", {{name, value}}}}),
                        std::string(name) + ": expected a number from 0 to 1, found ");
    expect_contains(refused({{"emissiveFactor", {-5, 0, 0}}}),
                    "emissiveFactor times emissiveStrength: expected a number");
    expect_contains(refused({{"extensions", {{"KHR_materials_transmission", {{"transmissionFactor", 2}}}}}}),
                    "transmissionFactor: expected a number from 0 to 1, found 2");
}

TEST_F(HostileModelTest, SparseIndexOutOfRange) {
    GltfBuilder builder = GltfBuilder::triangle();
    const int indices = builder.view(GltfBuilder::bytes_of<std::uint16_t>({3}));
    const int values = builder.view(GltfBuilder::bytes_of<float>({5, 6, 7}));
    builder.json["accessors"][0]["sparse"] = {
        {"count", 1},
        {"indices", {{"bufferView", indices}, {"componentType", gl_unsigned_short}, {"byteOffset", 0}}},
        {"values", {{"bufferView", values}, {"byteOffset", 0}}}};
    expect_contains(refusal(builder), "indices below 3, found 3");
}

TEST_F(HostileModelTest, NotFinite) {
    GltfBuilder builder = GltfBuilder::triangle();
    const float nan = std::numeric_limits<float>::quiet_NaN();
    std::memcpy(builder.buffer.data() + 8, &nan, 4);
    expect_contains(refusal(builder), "finite");
    builder = GltfBuilder::triangle();
    builder.json["nodes"][0]["translation"] = {1e300, 0, 0};
    expect_contains(refusal(builder), "finite");
}

TEST_F(HostileModelTest, BeyondTheLimitOfCoordinates) {
    const auto vertex_at = [](float x) {
        GltfBuilder builder = GltfBuilder::triangle();
        std::memcpy(builder.buffer.data(), &x, 4);
        return builder;
    };
    EXPECT_NO_THROW(load_model(write("far.glb", vertex_at(1e9f).glb())));
    expect_contains(refusal(vertex_at(1e19f)), "coordinates from -1e9 to 1e9, found (1e+19, ");
    expect_contains(refusal(vertex_at(-1.1e9f)), "coordinates from -1e9 to 1e9, found (-1.1e+09, ");
    GltfBuilder placed = vertex_at(1e5f);
    placed.json["nodes"][0]["scale"] = {1e5, 1, 1};
    expect_contains(refusal(placed), "in metres: expected coordinates from -1e9 to 1e9, found (1e+10, ");
    placed.json["nodes"][0]["scale"] = {1e3, 1, 1};
    SceneDescription scene;
    scene.model = write("unit.glb", placed.glb());
    EXPECT_NO_THROW(load_model(scene));
    scene.model_unit_m = 100;
    expect_contains(input_error([&] { load_model(scene); }), "in metres: expected coordinates from -1e9 to 1e9");
}

TEST_F(HostileModelTest, UnknownRequiredExtension) {
    GltfBuilder builder = GltfBuilder::triangle();
    builder.json["extensionsRequired"] = {"KHR_draco_mesh_compression"};
    const std::string error = refusal(builder);
    expect_contains(error, "found KHR_draco_mesh_compression");
    expect_contains(error, "KHR_mesh_quantization");
}

TEST_F(HostileModelTest, NothingInIt) {
    GltfBuilder builder = GltfBuilder::triangle();
    builder.json["nodes"] = Json::array();
    expect_contains(refusal(builder), "at least one triangle");
}

TEST_F(HostileModelTest, DamagedMask) {
    GltfBuilder builder = GltfBuilder::triangle();
    builder.json["images"] = {{{"bufferView", builder.view("notapng!")}, {"mimeType", "image/png"}}};
    builder.json["textures"] = {{{"source", 0}}};
    builder.json["materials"] = {
        {{"alphaMode", "MASK"}, {"pbrMetallicRoughness", {{"baseColorTexture", {{"index", 0}}}}}}};
    expect_contains(refusal(builder), "texture 0");
    builder.json["textures"] = {{{"source", 3}}};
    expect_contains(refusal(builder), "image");

    std::string png = png_rgba(2, 1, {255, 0, 0, 255, 0, 255, 0, 0});
    png[png.find("IDAT") + 6] ^= 1;
    builder.json["images"] = {{{"bufferView", builder.view(png)}, {"mimeType", "image/png"}}};
    builder.json["textures"] = {{{"source", 0}}};
    ::testing::internal::CaptureStderr();
    expect_contains(refusal(builder), "texture 0: expected a whole PNG image, found a damaged chunk IDAT");
    EXPECT_EQ(::testing::internal::GetCapturedStderr(), "") << "libpng's own line";
}

TEST_F(HostileModelTest, OneImageAsThousandsOfTexturesAndMasks) {
    constexpr int count = 4100;
    GltfBuilder builder = GltfBuilder::triangle();
    const std::string megabyte(1 << 20, '\0');
    builder.json["images"] = {{{"bufferView", builder.view(megabyte)}, {"mimeType", "image/png"}}};
    for (int i = 0; i < count; ++i)
        builder.json["textures"].push_back({{"source", 0}});
    expect_contains(refusal(builder), "expected textures of at most 4 GiB in all, found 4.00");

    builder = GltfBuilder::triangle();
    const std::string png = png_rgba(1024, 1024, std::vector<std::uint8_t>(4 << 20));
    builder.json["images"] = {{{"bufferView", builder.view(png)}, {"mimeType", "image/png"}}};
    builder.json["textures"] = {{{"source", 0}}};
    for (int i = 0; i < count; ++i)
        builder.json["materials"].push_back({{"alphaMode", "MASK"},
                                             {"alphaCutoff", (i + 1.0) / count},
                                             {"pbrMetallicRoughness", {{"baseColorTexture", {{"index", 0}}}}}});
    expect_contains(refusal(builder), "expected masks of at most 4 GiB in all, found 4.00");
}

/// Random damage to a whole file: loads or is refused, but never crashes, hangs or eats memory.
TEST_F(HostileModelTest, RandomDamage) {
    const std::string whole = GltfBuilder::triangle().glb();
    std::mt19937 random(3);
    for (int round = 0; round < 400; ++round) {
        std::string bytes = whole;
        for (int i = 0; i < 1 + round % 4; ++i)
            bytes[random() % bytes.size()] = static_cast<char>(random());
        const std::filesystem::path file = write("damaged.glb", bytes);
        try {
            const SceneModel model = load_model(file);
            EXPECT_GE(model.triangle_count(), 1u);
        } catch (const InputError& error) {
            expect_contains(error.what(), file.string());
        }
    }
}

}  // namespace equistream::test
